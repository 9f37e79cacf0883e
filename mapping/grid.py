"""The geometry of a grid: which cell covers which point. Every map shares it."""

from dataclasses import dataclass
from math import ceil, floor

import numpy as np
from numpy.typing import NDArray

Patch = tuple[slice, slice]
"""Rows and columns that an update touched."""


@dataclass(frozen=True, slots=True)
class GridGeometry:
    """Square cells; row 0 is the southernmost, column 0 the westernmost.

    `x` and `y` (m) are the lower-left corner of cell (0, 0) in the grid's frame.
    """

    resolution: float
    x: float
    y: float
    rows: int
    cols: int

    def __post_init__(self) -> None:
        if not self.resolution > 0 or self.rows < 1 or self.cols < 1:
            raise ValueError("a grid needs a positive resolution and at least one cell")

    @classmethod
    def covering(
        cls, west: float, south: float, east: float, north: float, resolution: float
    ) -> "GridGeometry":
        """The smallest grid over a box (m) whose cell borders lie on multiples of the resolution."""
        col, row = floor(west / resolution), floor(south / resolution)
        cols, rows = ceil(east / resolution) - col, ceil(north / resolution) - row
        return cls(resolution, col * resolution, row * resolution, max(rows, 1), max(cols, 1))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.rows, self.cols

    @property
    def x_centres(self) -> NDArray[np.float64]:
        """(cols,) the cells' centres, m."""
        return self.x + (np.arange(self.cols, dtype=np.float64) + 0.5) * self.resolution

    @property
    def y_centres(self) -> NDArray[np.float64]:
        """(rows,) the cells' centres, m."""
        return self.y + (np.arange(self.rows, dtype=np.float64) + 0.5) * self.resolution

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """Row and column over a point; they may lie outside the grid."""
        return floor((y - self.y) / self.resolution), floor((x - self.x) / self.resolution)

    def contains(self, row: int, col: int) -> bool:
        """Whether the grid has that cell."""
        return 0 <= row < self.rows and 0 <= col < self.cols

    def window(self, west: float, south: float, east: float, north: float) -> Patch:
        """The part of the grid over a box (m); its slices are empty where the box lies outside."""
        first_row, first_col = self.cell(west, south)
        last_row, last_col = self.cell(east, north)
        return _clip(first_row, last_row, self.rows), _clip(first_col, last_col, self.cols)


def _clip(first: int, last: int, size: int) -> slice:
    start = min(max(first, 0), size)
    return slice(start, min(max(last + 1, start), size))
