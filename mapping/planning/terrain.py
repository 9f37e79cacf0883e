"""What it costs a robot to be in a cell, by what is remembered."""

from dataclasses import dataclass
from functools import cached_property
from math import ceil, hypot, inf

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.planning.clearance import clearance
from echogrid.mapping.planning.recollection import Recollection
from echogrid.mapping.planning.wavefront import Cell, Floats

Point = tuple[float, float]
"""x and y, m, in the odom frame."""
Mask = NDArray[np.bool_]
Cells = tuple[NDArray[np.intp], NDArray[np.intp]]
"""Rows and columns."""

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
    clearance: Floats
    """(rows, cols) m, inf beyond what matters."""
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
        """Rows and columns of the cells under points (n, 2), of the nearest where they lie outside."""
        geometry = self.geometry
        rows = np.floor((points[:, 1] - geometry.y) / geometry.resolution).astype(np.intp)
        cols = np.floor((points[:, 0] - geometry.x) / geometry.resolution).astype(np.intp)
        return np.clip(rows, 0, geometry.rows - 1), np.clip(cols, 0, geometry.cols - 1)

    def along(self, here: Point, there: Point) -> Cells:
        """Rows and columns beneath the straight way, every half a cell."""
        (x, y), (to_x, to_y) = here, there
        count = ceil(2.0 * hypot(to_x - x, to_y - y) / self.geometry.resolution) + 1
        shares = np.linspace(0.0, 1.0, count + 1)
        return self.beneath(np.stack((x + shares * (to_x - x), y + shares * (to_y - y)), axis=1))

    def is_open(self, here: Point, there: Point) -> bool:
        """Whether the straight way may be driven: blocked cells, if passable, at its two ends only."""
        cells = self.along(here, there)
        free = np.flatnonzero(~self.blocked[cells])
        in_one = not len(free) or len(free) == free[-1] - free[0] + 1
        return bool(in_one and self.passable[cells].all())

    def price(self, here: Point, there: Point) -> float:
        """m of the straight way, dear stretches counted as longer."""
        weights = self.weights[self.along(here, there)]
        return hypot(there[0] - here[0], there[1] - here[1]) * float(weights.mean())


def terrain(memory: Recollection, prices: Prices, ends: tuple[Point, ...]) -> Terrain:
    """Of what is remembered. Around each of the `ends` that is too near an obstacle it is dear, not shut."""
    geometry = memory.geometry
    reach = prices.keep + prices.shy
    distance = clearance(memory.belief > 0, ceil(reach / geometry.resolution)) * geometry.resolution
    blocked = distance < prices.keep
    close = np.maximum(1.0 - (distance - prices.keep) / prices.shy, 0.0) if prices.shy else np.zeros(1)
    weights = 1.0 + prices.near * close**2
    weights[memory.belief == 0] *= prices.unknown
    weights[blocked] = inf
    for end in ends:
        weights[_squeezed(geometry, distance, blocked, (end, prices.keep))] = prices.squeeze
    return Terrain(geometry, distance, blocked, weights)


def _squeezed(geometry: GridGeometry, distance: Floats, blocked: Mask, disc: tuple[Point, float]) -> Mask:
    """(rows, cols) the blocked cells around a point that lies in one, but for those at the obstacle."""
    (x, y), keep = disc
    cell = geometry.cell(x, y)
    if not (geometry.contains(*cell) and blocked[cell]):
        return np.zeros_like(blocked)
    away = np.hypot(geometry.x_centres[np.newaxis, :] - x, geometry.y_centres[:, np.newaxis] - y)
    around = away <= keep + geometry.resolution
    return np.asarray(blocked & around & (distance > _NARROWEST * geometry.resolution))
