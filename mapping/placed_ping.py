"""A reading with its place."""

from dataclasses import dataclass

from echogrid.drivers.readings import RangeReading
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger


@dataclass(frozen=True, slots=True)
class PlacedPing:
    """A reading, and where its transducer was (map frame) when the sound met the obstacle."""

    reading: RangeReading
    ranger: Ranger
    transducer: Pose
