"""The cones of several pings on a grid at once: for each the cells that cone.cast finds, all in one array.

What may lie in a cone at all is looked up, by the direction in which it looks, for a transducer anywhere in
its cell; the exact test is for these few only.
"""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, cos, floor, hypot, pi, sin, tan, tau
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.cone import Floats, Reach
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose

Indices = NDArray[np.intp]

_DIRECTIONS = 64
_PER_RADIAN = _DIRECTIONS / tau
_STEP = 4.0
"""m: what is looked up reaches so far, or twice as far..."""
_ROUNDING = 1e-9
"""m."""


@dataclass(frozen=True, slots=True)
class Cones:
    """Arrays of shape (n,), the cells of one ping after those of the other."""

    cells: Indices
    """row * columns + column."""
    distance: Floats
    """m, from the transducer to the cell's centre."""
    bearing: Floats
    """rad, off the axis."""
    ping: Indices
    """Whose cell it is, rising."""
    borders: list[int]
    """Where each ping's cells begin, and where the last one's end."""


def cast_all(geometry: GridGeometry, pings: Sequence[tuple[Pose, Reach]]) -> Cones:
    """The cones of pings from those poses which speak so far, on a grid; at least one."""
    candidates = [_candidates(geometry, *ping) for ping in pings]
    cells = np.concatenate(candidates)
    ping = np.repeat(np.arange(len(pings)), [len(each) for each in candidates])
    x, y, c, s, slope, square = (each.take(ping) for each in _table(pings))
    dx, dy = (each.take(cells) for each in _centres(geometry))
    dx -= x
    dy -= y
    along, across = c * dx + s * dy, c * dy - s * dx
    squared = along * along + across * across
    inside = np.abs(across) <= np.maximum(along * slope, geometry.resolution / 2.0)
    inside &= along > 0.0
    inside &= squared <= square
    (chosen,) = inside.nonzero()
    ping = ping.take(chosen)
    return Cones(
        cells.take(chosen),
        np.sqrt(squared.take(chosen)),
        np.abs(np.arctan2(across.take(chosen), along.take(chosen))),
        ping,
        np.searchsorted(ping, np.arange(len(pings) + 1)).tolist(),
    )


def _table(pings: Sequence[tuple[Pose, Reach]]) -> Floats:
    """(6, pings) place, direction, slope of the cone's sides, and the square of its reach."""
    rows = [
        (at.x, at.y, cos(at.yaw), sin(at.yaw), tan(reach.half_angle), reach.distance * reach.distance)
        for at, reach in pings
    ]
    return np.array(rows).T.copy()


@lru_cache(maxsize=8)
def _centres(geometry: GridGeometry) -> tuple[Floats, Floats]:
    """(rows * columns,) m, x and y of the cells' centres."""
    x, y = np.meshgrid(geometry.x_centres, geometry.y_centres)
    return x.ravel(), y.ravel()


def _candidates(geometry: GridGeometry, at: Pose, reach: Reach) -> Indices:
    """The cells which may lie in a cone."""
    resolution, rows, cols = geometry.resolution, geometry.rows, geometry.cols
    row, col = geometry.cell(at.x, at.y)
    most = min(reach.distance, (rows + cols) * resolution)
    direction = floor(at.yaw * _PER_RADIAN) % _DIRECTIONS
    around = _around(resolution, cols, Reach(reach.half_angle, _STEP * ceil(most / _STEP)), direction)
    count = bisect_right(around.distance, most + resolution)
    cells = around.cells[:count] + (row * cols + col)
    room = int(most / resolution) + 2
    if room <= row < rows - room and room <= col < cols - room:
        return cells
    up, right = around.rows[:count] + row, around.cols[:count] + col
    kept: Indices = cells[(up >= 0) & (up < rows) & (right >= 0) & (right < cols)]
    return kept


class _Around(NamedTuple):
    """Cells by how far they are from the transducer's, the nearest first; each (n,)."""

    rows: Indices
    """Upwards from the transducer's."""
    cols: Indices
    cells: Indices
    """rows * columns + cols."""
    distance: list[float]
    """m, from middle to middle."""


@lru_cache(maxsize=1024)
def _around(resolution: float, columns: int, reach: Reach, direction: int) -> _Around:
    """Those which may lie in a cone that looks in one of the directions, from anywhere in the middle cell."""
    half = ceil(reach.distance / resolution) + 2
    steps = np.arange(-half, half + 1)
    cols, rows = (each.ravel() for each in np.meshgrid(steps, steps))
    yaw, turn = (direction + 0.5) * tau / _DIRECTIONS, 0.5 * tau / _DIRECTIONS
    along = (cols * cos(yaw) + rows * sin(yaw)) * resolution
    across = np.abs(rows * cos(yaw) - cols * sin(yaw)) * resolution
    distance = np.hypot(along, across)
    # It is up to half a diagonal from its cell's middle, and half a cell beside the axis counts, too.
    aside, wide = resolution * (hypot(0.5, 0.5) + 0.5) + _ROUNDING, reach.half_angle + turn
    near = distance <= reach.distance + resolution
    if wide < 0.5 * pi:
        near &= across * cos(wide) - along * sin(wide) <= aside
    chosen = np.flatnonzero(near)
    chosen = chosen[np.argsort(distance[chosen], kind="stable")]
    rows, cols = rows[chosen], cols[chosen]
    return _Around(rows, cols, rows * columns + cols, distance[chosen].tolist())
