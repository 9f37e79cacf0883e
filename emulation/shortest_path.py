"""The shortest way for a round robot through a true plan: what a driven way is measured by.

Dijkstra on a grid of the places where the robot's middle may be, to all eight neighbours; then the way is
pulled tight, for a way on a grid is up to 8 % longer than the straight one.
"""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, floor, hypot, inf, sqrt

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.vista import Point
from echogrid.emulation.world import World

FloatArray = NDArray[np.float64]
Cell = tuple[int, int]
"""Row and column."""

RESOLUTION = 0.1
"""m."""
_BORDER = 2
"""Cells around the walls, which nobody reaches."""
_STEPS = tuple(
    (down, right, sqrt(2.0) if down and right else 1.0)
    for down in (-1, 0, 1)
    for right in (-1, 0, 1)
    if down or right
)


@dataclass(frozen=True, eq=False)
class Floor:
    """Where the middle of a robot may be; row 0 is the southernmost."""

    clearance: FloatArray
    """(rows, cols) m from each cell's middle to the nearest surface."""
    radius: float
    """m, of the robot and what it shall keep away."""
    west: float
    south: float
    resolution: float = RESOLUTION

    @classmethod
    def of(cls, world: World, radius: float, resolution: float = RESOLUTION) -> "Floor":
        """The floor of a world, for a robot of this radius."""
        corners = world.walls.reshape(-1, 2)
        west, south = (floor(low / resolution) - _BORDER for low in corners.min(axis=0))
        east, north = (ceil(high / resolution) + _BORDER for high in corners.max(axis=0))
        x, y = np.meshgrid(np.arange(west, east) + 0.5, np.arange(south, north) + 0.5)
        places = resolution * np.column_stack((x.ravel(), y.ravel()))
        clearance = world.surface_distance(places).reshape(x.shape)
        return cls(clearance, radius, west * resolution, south * resolution, resolution)

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """(rows, cols)."""
        return np.asarray(self.clearance >= self.radius)

    @cached_property
    def _passable(self) -> list[list[bool]]:
        rows: list[list[bool]] = self.free.tolist()
        return rows

    def cell(self, point: Point) -> Cell:
        """The cell over a point, m; it may lie outside."""
        x, y = point
        return floor((y - self.south) / self.resolution), floor((x - self.west) / self.resolution)

    def middle(self, cell: Cell) -> Point:
        """m."""
        row, col = cell
        return self.west + (col + 0.5) * self.resolution, self.south + (row + 0.5) * self.resolution

    def lengths_from(self, start: Cell) -> tuple[FloatArray, dict[Cell, Cell]]:
        """(rows, cols) m of the shortest way on the grid, inf where none leads; and the cell before each."""
        lengths = np.full(self.free.shape, inf)
        passable, settled = self._passable, set[Cell]()
        before: dict[Cell, Cell] = {}
        best = {start: 0.0}
        queue = [(0.0, start)] if self._may(start) else []
        while queue:
            length, here = heapq.heappop(queue)
            if here in settled:
                continue
            settled.add(here)
            lengths[here] = length * self.resolution
            row, col = here
            for down, right, step in _STEPS:
                there = row + down, col + right
                if passable[there[0]][there[1]] and length + step < best.get(there, inf):
                    best[there], before[there] = length + step, here
                    heapq.heappush(queue, (length + step, there))
        return lengths, before

    def tight(self, way: Sequence[Point]) -> float:
        """m, of a way from cell to cell after it was pulled tight around what it passes."""
        total, first = 0.0, 0
        while first < len(way) - 1:
            last = first + 1
            while last + 1 < len(way) and self._is_open(way[first], way[last + 1]):
                last += 1
            total += hypot(way[last][0] - way[first][0], way[last][1] - way[first][1])
            first = last
        return total

    def _may(self, cell: Cell) -> bool:
        row, col = cell
        rows, cols = self.free.shape
        return 0 <= row < rows and 0 <= col < cols and self._passable[row][col]

    def _is_open(self, here: Point, there: Point) -> bool:
        """Whether the straight way leads over free cells alone."""
        steps = max(ceil(2.0 * hypot(there[0] - here[0], there[1] - here[1]) / self.resolution), 1)
        shares = np.linspace(0.0, 1.0, steps + 1)
        cols = np.floor((here[0] + shares * (there[0] - here[0]) - self.west) / self.resolution)
        rows = np.floor((here[1] + shares * (there[1] - here[1]) - self.south) / self.resolution)
        return bool(self.free[rows.astype(np.intp), cols.astype(np.intp)].all())


def traced(before: dict[Cell, Cell], goal: Cell) -> list[Cell]:
    """The cells from the start to the goal."""
    way = [goal]
    while way[-1] in before:
        way.append(before[way[-1]])
    return way[::-1]
