"""The long-term map: submaps, each a grid anchored to a pose, rendered into one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.theory import Theory, layers


@dataclass(slots=True)
class Submap:
    """A grid whose frame stands at `anchor` in the map frame."""

    anchor: Pose
    grid: Theory


@dataclass(frozen=True, slots=True)
class MapImage:
    """A map as it is published, in the map frame."""

    geometry: GridGeometry
    occupancy: NDArray[np.float32]
    """(rows, cols) P(Occupied), row 0 = south."""
    unknown: NDArray[np.bool_]
    """(rows, cols)."""
    layers: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
    """(rows, cols) each: what else the theory has to tell, by name."""


class LongTermMap:
    """All that was seen, in submaps. Until something corrects poses, there is one."""

    def __init__(
        self, geometry: GridGeometry, tolerance: float, theory: Callable[[GridGeometry], Theory]
    ) -> None:
        self._tolerance = tolerance
        self._submap = Submap(Pose(), theory(geometry))

    def fuse(self, transducer: Pose, ranger: Ranger, echo_distance: float | None, stamp_ns: int = 0) -> bool:
        """Fuse a ping sent from `transducer` (map frame); False if it said nothing about the map's area."""
        grid = self._submap.grid
        seat = self._submap.anchor.inverse().compose(transducer)
        tolerance = self._tolerance if ranger.tolerance is None else ranger.tolerance
        return grid.update(Sounding(seat, ranger, echo_distance, tolerance, stamp_ns)) is not None

    def render(self) -> MapImage:
        """The published map."""
        grid = self._submap.grid
        return MapImage(grid.geometry, grid.occupancy(), grid.unknown(), layers(grid))
