"""The active window: the cells around the robot which may turn it aside, and all that is the same each time.

The robot is somewhere in the middle cell. What is kept here is reckoned from that cell's middle.
"""

from dataclasses import dataclass
from math import sqrt, tau

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.steering.sectors import Floats, Indices

_ROUNDING = 1e-9
"""Sectors: a border that lies on a sector's direction includes it, on both sides."""


@dataclass(frozen=True, slots=True)
class Body:
    """The robot as a disc around base_link, which is what turns in place without hitting anything."""

    radius: float = 0.2
    """m."""
    margin: float = 0.1
    """m: what it keeps from obstacles."""

    def __post_init__(self) -> None:
        if not (self.radius > 0.0 and self.margin >= 0.0):
            raise ValueError("a robot needs a radius above 0, and a margin that is not below 0")


class Window:
    """The cells of a square grid whose middles lie within `horizon` (m) of the middle cell's, nearest first.

    The grid has `cells` on a side and the robot in its cell (cells // 2, cells // 2), as a LocalGrid.
    """

    def __init__(
        self, resolution: float, cells: int, body: Body, horizon: float = 1.65, sectors: int = 72
    ) -> None:
        middle = cells // 2
        self.resolution = resolution
        self.body = body
        self.sectors = sectors
        self.half = min(int(horizon / resolution + _ROUNDING), cells - 1 - middle)
        """(w_s - 1)/2 of a window w_s cells wide."""
        if self.half < 1 or sectors < 8 or sectors % 4:
            raise ValueError(
                "a window needs a horizon of a cell at least within its grid, and 8, 12, 16... sectors"
            )
        self.horizon = self.half * resolution
        up, right = _disc(self.half)
        self.flat: Indices = (up + middle) * cells + right + middle
        """(n,) the cells' places in the grid's flattened arrays; the middle cell is the first."""
        self.x: Floats = right.astype(np.float64) * resolution
        """(n,) m, east of the middle."""
        self.y: Floats = up.astype(np.float64) * resolution
        self.squared: Floats = (up**2 + right**2).astype(np.float64)
        """(n,) d^2 in cells, whole numbers."""
        self.distance: Floats = np.sqrt(self.squared) * resolution
        self.bearing: Floats = np.arctan2(up.astype(np.float64), right.astype(np.float64))
        """(n,) beta, rad in -pi...pi, in the grid's frame."""
        self.keep = body.radius + body.margin + resolution / sqrt(2.0)
        """m: a disc of this size around the cell's middle holds the robot and its margin, wherever in it."""
        self.directions: Floats = np.arange(sectors, dtype=np.float64) * (tau / sectors)
        """(sectors,) rad."""
        turns = self.bearing / tau * sectors
        self.nearest_sector: Indices = np.rint(turns).astype(np.intp) % sectors
        """(n,) the sector whose direction is nearest to the cell's."""
        self.first, self.last = self._enlarged(turns)
        """(n,) a cell blocks the sectors first...last; 0 <= first < sectors, last may lie beyond the seam."""

    def within(self, distance: float) -> int:
        """How many of the cells lie within that distance (m)."""
        return int(self.distance.searchsorted(distance, "right"))

    def _enlarged(self, turns: Floats) -> tuple[Indices, Indices]:
        """The sectors k with k alpha in [beta - gamma, beta + gamma]; at least the nearest one."""
        gamma = enlargement(self.keep, self.distance) / tau * self.sectors
        first = np.ceil(turns - gamma - _ROUNDING).astype(np.intp)
        last = np.floor(turns + gamma + _ROUNDING).astype(np.intp)
        none = last < first
        first[none] = last[none] = np.rint(turns[none]).astype(np.intp)
        start = first % self.sectors
        return start, start + last - first


def enlargement(keep: float, distance: NDArray[np.float64]) -> Floats:
    """gamma = asin((r_robot + d_safe)/d), rad: by how much an obstacle is wider for the robot's middle.

    What is nearer than that is neither behind nor ahead of a tangent: it blocks the half circle on its side.
    (Ulrich & Borenstein 1998.)
    """
    gamma: Floats = np.arcsin(np.minimum(keep / np.maximum(distance, keep), 1.0))
    return gamma


def _disc(half: int) -> tuple[Indices, Indices]:
    """Rows and columns of all cells within `half` cells, from the middle, the nearest first."""
    rows, cols = np.mgrid[-half : half + 1, -half : half + 1]
    squared = rows**2 + cols**2
    inside = np.flatnonzero(squared.ravel() <= half**2)
    order = inside[np.argsort(squared.ravel()[inside], kind="stable")]
    return rows.ravel()[order], cols.ravel()[order]
