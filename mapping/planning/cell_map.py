"""A map whose cells are occupied, free or neither, and the floor plan that it gives."""

from dataclasses import dataclass
from itertools import product
from math import ceil, cos, floor, hypot, sin

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.planning.floor_plan import SPACING, FloorPlan, Points, placed
from echogrid.mapping.pose import Pose

Mask = NDArray[np.bool_]

_STEPS = ((0, 1), (1, 0), (1, 1), (1, -1))
"""Rows and columns from a cell to half of its neighbours; the others have it for theirs."""


@dataclass(frozen=True, eq=False)
class CellMap:
    """Masks are (rows, cols), row 0 = south before the map is turned."""

    resolution: float
    """m."""
    origin: Pose
    """Of the lower-left corner of cell (0, 0), along whose row x leads, in the map's frame."""
    occupied: Mask
    free: Mask

    def cell(self, x: float, y: float) -> tuple[int, int] | None:
        """Row and column of a place (m, the map's frame); None outside."""
        c, s = cos(self.origin.yaw), sin(self.origin.yaw)
        x, y = x - self.origin.x, y - self.origin.y
        row, col = floor((c * y - s * x) / self.resolution), floor((c * x + s * y) / self.resolution)
        rows, cols = self.occupied.shape
        return (row, col) if 0 <= row < rows and 0 <= col < cols else None

    def floor_plan(self) -> FloorPlan:
        """In the map's frame. Its walls are lines through the middles of the occupied cells that border on
        something else."""
        return FloorPlan(self._placed(self._walls()), self._placed(self._free()))

    def _walls(self) -> Points:
        """(n, 2) rows and columns, in parts of cells."""
        edge = np.pad(self.occupied & _beside(~self.occupied), 1)
        parts = [np.argwhere(_moved(edge, 0, 0)).astype(np.float64)]
        for down, right in _STEPS:
            pairs = _moved(edge, 0, 0) & _moved(edge, down, right)
            if down and right:  # Across a corner only where no cell leads around it.
                pairs &= ~_moved(edge, down, 0) & ~_moved(edge, 0, right)
            cells, count = np.argwhere(pairs), self._count(hypot(down, right))
            parts += [cells + np.array((down, right)) * (part / count) for part in range(1, count)]
        return np.concatenate(parts)

    def _free(self) -> Points:
        """(n, 2) rows and columns, in parts of cells."""
        cells, count = np.argwhere(self.free), self._count(1.0)
        shares = [(part + 0.5) / count - 0.5 for part in range(count)]
        return np.concatenate([cells + np.array(at) for at in product(shares, shares)])

    def _count(self, cells: float) -> int:
        """Into how many parts so long a way is divided; a file's 0.0500000007 m is 0.05 m."""
        return max(ceil(cells * self.resolution / SPACING - 1e-6), 1)

    def _placed(self, cells: Points) -> Points:
        return placed((cells[:, ::-1] + 0.5) * self.resolution, self.origin)


def _moved(padded: Mask, down: int, right: int) -> Mask:
    """What is so many rows and columns on from each cell of a mask with a margin of one."""
    rows, cols = padded.shape
    return padded[1 + down : rows - 1 + down, 1 + right : cols - 1 + right]


def _beside(mask: Mask) -> Mask:
    """(rows, cols) which cells have one of those, or the map's end, among their eight neighbours."""
    padded = np.pad(mask, 1, constant_values=True)
    beside = np.zeros(mask.shape, np.bool_)
    for down, right in product((-1, 0, 1), repeat=2):
        beside |= _moved(padded, down, right)
    return beside
