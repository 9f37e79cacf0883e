"""One ping with all that a theory needs to know of it."""

from dataclasses import dataclass

from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger


@dataclass(frozen=True, slots=True)
class Sounding:
    """A ping sent from `transducer`, its pose in the frame of the grid."""

    transducer: Pose
    ranger: Ranger
    echo: float | None
    """m, the reading s; None: nothing came back within the ranger's reach."""
    tolerance: float
    """m: half the thickness of the band in which the obstacle lies, at least."""
    stamp_ns: int = 0
    """When the sound met the obstacle; of no weight for a map."""
