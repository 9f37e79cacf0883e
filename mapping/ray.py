"""Which cells a straight line crosses."""

from dataclasses import dataclass
from math import ceil, cos, floor, sin

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.cone import Floats
from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.pose import Pose

_TOUCH = 1e-9
"""m: a cell whose corner the line only touches is not crossed."""


@dataclass(frozen=True, slots=True)
class Ray:
    """The cells on a line, each array of shape (n,), in the line's order. All are in the grid."""

    rows: NDArray[np.intp]
    cols: NDArray[np.intp]

    @property
    def patch(self) -> Patch:
        """The part of the grid that holds them all; empty if there are none."""
        if not len(self.rows):
            return slice(0, 0), slice(0, 0)
        rows, cols = self.rows, self.cols
        return slice(int(rows.min()), int(rows.max()) + 1), slice(int(cols.min()), int(cols.max()) + 1)


def cross(geometry: GridGeometry, start: Pose, length: float) -> Ray:
    """The cells of which a line from `start` along its yaw, `length` m long, crosses more than a corner.

    The line is cut at every border that it crosses; each piece lies in one cell, that of its middle.
    """
    dx, dy = cos(start.yaw), sin(start.yaw)
    cuts = np.concatenate(
        (
            [0.0, length],
            _cuts(
                (start.x - geometry.x) / geometry.resolution, dx / geometry.resolution, length, geometry.cols
            ),
            _cuts(
                (start.y - geometry.y) / geometry.resolution, dy / geometry.resolution, length, geometry.rows
            ),
        )
    )
    cuts.sort()
    pieces = np.diff(cuts) > _TOUCH
    middle = (cuts[:-1][pieces] + cuts[1:][pieces]) / 2.0
    cols = np.floor((start.x + middle * dx - geometry.x) / geometry.resolution).astype(np.intp)
    rows = np.floor((start.y + middle * dy - geometry.y) / geometry.resolution).astype(np.intp)
    inside = (rows >= 0) & (rows < geometry.rows) & (cols >= 0) & (cols < geometry.cols)
    return Ray(rows[inside], cols[inside])


def _cuts(place: float, step: float, length: float, cells: int) -> Floats:
    """How far along the line (m) the borders of one axis lie; `place` in cells, `step` in cells a metre."""
    if abs(step) * length < _TOUCH:
        return np.empty(0)
    ends = sorted((place, place + step * length))
    first, last = max(ceil(ends[0]), 0), min(floor(ends[1]), cells)
    return np.clip((np.arange(first, last + 1) - place) / step, 0.0, length)
