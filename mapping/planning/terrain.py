"""What it costs a robot to be in a cell, by what is remembered."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil, hypot, inf

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.planning.clearance import roots, squares
from echogrid.mapping.planning.recollection import Recollection
from echogrid.mapping.planning.wavefront import Cell, Floats

Point = tuple[float, float]
"""x and y, m, in the memory's frame."""
Mask = NDArray[np.bool_]
Cells = NDArray[np.intp]
"""row * columns + column."""

_NARROWEST = 1.5
"""Cells from an obstacle's middle; nearer no way leads: it might slip between two that touch at corners."""


@dataclass(frozen=True, slots=True)
class Prices:
    """What a metre costs, beside 1 where it is known to be free."""

    keep: float = 0.3
    """m: nearer to an obstacle the robot's middle shall not come: its radius and a margin."""
    shy: float = 0.4
    """m beyond that, within which it costs more ..."""
    near: float = 2.0
    """... up to this much more."""
    unknown: float = 1.3
    """Times as much where nothing is known."""
    squeeze: float = 20.0
    """Within `keep`, where the robot or the goal is there already."""

    def __post_init__(self) -> None:
        if self.keep <= 0.0 or min(self.shy, self.near) < 0.0 or min(self.unknown, self.squeeze) < 1.0:
            raise ValueError("keep must be above 0, shy and near at least 0, unknown and squeeze at least 1")


@dataclass(frozen=True, eq=False)
class Terrain:
    """Its arrays are its own."""

    geometry: GridGeometry
    blocked: Mask
    """(rows, cols) too near to an obstacle."""
    weights: Floats
    """(rows, cols) what a length costs there; inf where none may be."""

    @cached_property
    def passable(self) -> Mask:
        """(rows, cols)."""
        return np.isfinite(self.weights)

    def middle(self, cell: Cell) -> Point:
        """m."""
        geometry = self.geometry
        return (
            geometry.x + (cell[1] + 0.5) * geometry.resolution,
            geometry.y + (cell[0] + 0.5) * geometry.resolution,
        )

    def nearest(self, point: Point) -> Cell | None:
        """The passable cell over the point, or the nearest to it; None if there is none."""
        cell = self.geometry.cell(*point)
        if self.geometry.contains(*cell) and self.passable[cell]:
            return cell
        rows, cols = np.nonzero(self.passable)
        if not len(rows):
            return None
        away = np.hypot(self.geometry.x_centres[cols] - point[0], self.geometry.y_centres[rows] - point[1])
        best = int(away.argmin())
        return int(rows[best]), int(cols[best])

    def beneath(self, points: Floats) -> Cells:
        """The cells under points (n, 2), or the nearest where they lie outside."""
        return self._beneath(points[:, 0], points[:, 1])

    def _beneath(self, x: Floats, y: Floats) -> Cells:
        # Cut off, not rounded down: what lies below 0 is brought to 0 in any case.
        geometry = self.geometry
        rows = ((y - geometry.y) / geometry.resolution).astype(np.intp)
        cols = ((x - geometry.x) / geometry.resolution).astype(np.intp)
        rows = np.minimum(np.maximum(rows, 0), geometry.rows - 1)
        rows *= geometry.cols
        rows += np.minimum(np.maximum(cols, 0), geometry.cols - 1)
        return rows

    def along(self, here: Point, there: Point) -> Cells:
        """The cells beneath the straight way, every half a cell."""
        (x, y), (to_x, to_y) = here, there
        shares = shared(ceil(2.0 * hypot(to_x - x, to_y - y) / self.geometry.resolution) + 1)
        return self._beneath(x + shares * (to_x - x), y + shares * (to_y - y))

    def is_open(self, here: Point, there: Point) -> bool:
        """Whether the straight way may be driven: blocked cells, if passable, at its two ends only."""
        cells = self.along(here, there)
        blocked = self.blocked.take(cells)
        if not np.logical_or.reduce(blocked):
            return True
        (free,) = np.logical_not(blocked).nonzero()
        in_one = not len(free) or len(free) == free[-1] - free[0] + 1
        return bool(in_one and self.passable.take(cells).all())

    def price(self, here: Point, there: Point) -> float:
        """m of the straight way, dear stretches counted as longer."""
        weights = self.weights.take(self.along(here, there))
        return hypot(there[0] - here[0], there[1] - here[1]) * float(weights.mean())


@lru_cache(maxsize=1024)
def shared(parts: int) -> Floats:
    """(parts + 1,) 0...1 in so many parts."""
    shares = np.linspace(0.0, 1.0, parts + 1)
    shares.flags.writeable = False
    return shares


def terrain(memory: Recollection, prices: Prices, ends: tuple[Point, ...]) -> Terrain:
    """Of what is remembered. Around each of the `ends` that is too near an obstacle it is dear, not shut."""
    geometry = memory.geometry
    most = ceil((prices.keep + prices.shy) / geometry.resolution)
    squared, distance = squares(memory.belief > 0, most), roots(most) * geometry.resolution
    weights = _price(distance, prices).take(squared)
    blocked = weights == inf
    np.multiply(weights, prices.unknown, out=weights, where=memory.belief == 0)
    for end in ends:
        cell = geometry.cell(*end)
        if geometry.contains(*cell) and blocked[cell]:
            near = distance.take(squared) <= _NARROWEST * geometry.resolution
            weights[blocked & ~near & _around(geometry, end, prices.keep)] = prices.squeeze
    return Terrain(geometry, blocked, weights)


def _price(distance: Floats, prices: Prices) -> Floats:
    """(n,) what a length costs at distances (m, n) from the next obstacle, where it is known."""
    close = np.maximum(1.0 - (distance - prices.keep) / prices.shy, 0.0) if prices.shy else np.zeros(1)
    return np.where(distance < prices.keep, inf, 1.0 + prices.near * close**2)


def _around(geometry: GridGeometry, point: Point, keep: float) -> Mask:
    """(rows, cols) the cells that whatever keeps so far (m) from obstacles at a point may touch."""
    x, y = geometry.x_centres[np.newaxis, :] - point[0], geometry.y_centres[:, np.newaxis] - point[1]
    around: Mask = np.hypot(x, y) <= keep + geometry.resolution
    return around
