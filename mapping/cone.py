"""The sonar's cone on a grid: which cells one ping speaks about, and how strongly.

Murphy, Introduction to AI Robotics, 11.2-11.3. A cell at distance r and angle alpha from the transducer's
axis is in region I if |r - s| <= tolerance (an echo at s: probably occupied), in region II if it is nearer
(probably empty), and in region III, about which the ping says nothing, elsewhere.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, cos, floor, pi, sin, tan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger, effective_tolerance
from echogrid.mapping.sounding import Sounding

Floats = NDArray[np.float64]

_QUARTER = pi / 2.0


class Reach(NamedTuple):
    """How far a ping speaks to the side and ahead."""

    half_angle: float
    """rad."""
    distance: float
    """m."""


@dataclass(frozen=True, slots=True)
class Cone:
    """The cells of one ping's regions I and II, each array of shape (n,)."""

    patch: Patch
    """The part of the grid that holds them all."""
    geometry: GridGeometry
    """The grid's."""
    cells: NDArray[np.intp]
    """Which they are: row * columns + column, rising."""
    distance: Floats
    """m, r: from the transducer to the cell's centre."""
    bearing: Floats
    """rad, |alpha|: off the axis."""
    occupied: NDArray[np.bool_]
    """True in region I, False in region II."""
    echo: bool
    """False if nothing came back: then all of it is region II."""
    ranger: Ranger
    """As it was believed to be."""
    reading: float
    """m, s; the reach if nothing came back."""

    @property
    def rows(self) -> NDArray[np.intp]:
        """Of the cells."""
        return self.cells // self.geometry.cols

    @property
    def cols(self) -> NDArray[np.intp]:
        """Of the cells."""
        return self.cells % self.geometry.cols

    @property
    def belief(self) -> Floats:
        """b: how strongly the ping speaks, 0...1."""
        return belief(self.distance, self.bearing, self.ranger.farthest, self.ranger.half_angle)


def belief(distance: Floats, bearing: Floats, farthest: float, half_angle: float) -> Floats:
    """b = ((R - r)/R + (beta - |alpha|)/beta)/2, the common term of equations 11.1, 11.2, 11.7 and 11.8.

    Each half is kept from going negative: cells of a thick region I may lie beyond R, and near cells that
    touch the cone beyond beta.
    """
    near = np.maximum(farthest - distance, 0.0)
    near /= farthest
    central = np.maximum(half_angle - np.abs(bearing), 0.0)
    central /= half_angle
    near += central
    near /= 2.0
    return near


def cast(geometry: GridGeometry, sounding: Sounding) -> Cone:
    """The cone of a ping on a grid."""
    transducer, ranger = sounding.transducer, sounding.ranger
    echo = sounding.echo is not None
    s = ranger.farthest if sounding.echo is None else sounding.echo
    band = effective_tolerance(sounding.tolerance, geometry.resolution, s)
    reach = s + band if echo else s
    patch = geometry.window(*_bounds(transducer, ranger.half_angle, reach, geometry.resolution))
    along, across = _sensor_frame(geometry, patch, transducer)
    squared = along * along + across * across
    inside = _inside(along, across, ranger.half_angle, geometry.resolution)
    inside &= squared <= reach * reach
    # One-dimensional arrays are picked from several times as quickly as two-dimensional ones.
    (chosen,) = inside.ravel().nonzero()
    distance = np.sqrt(squared.take(chosen))
    return Cone(
        patch,
        geometry,
        _numbers(*geometry.shape)[patch].ravel().take(chosen),
        distance,
        np.abs(np.arctan2(across.take(chosen), along.take(chosen))),
        distance >= s - band if echo else np.zeros(len(chosen), np.bool_),
        echo,
        ranger,
        s,
    )


@lru_cache(maxsize=8)
def _numbers(rows: int, cols: int) -> NDArray[np.intp]:
    """(rows, cols) row * columns + column, of a grid's cells."""
    return np.arange(rows * cols).reshape(rows, cols)


def _inside(along: Floats, across: Floats, half_angle: float, resolution: float) -> NDArray[np.bool_]:
    """Within the cone, or within half a cell of its axis: a cone narrower than a cell still has no holes."""
    wide = along * tan(half_angle)
    np.maximum(wide, resolution / 2.0, out=wide)
    inside: NDArray[np.bool_] = np.abs(across) <= wide
    inside &= along > 0.0
    return inside


def _sensor_frame(geometry: GridGeometry, patch: Patch, transducer: Pose) -> tuple[Floats, Floats]:
    """The patch's cell centres along and across the axis, m."""
    resolution = geometry.resolution
    dx = _centres(geometry.x, resolution, geometry.cols)[patch[1]] - transducer.x
    dy = _centres(geometry.y, resolution, geometry.rows)[patch[0], np.newaxis] - transducer.y
    c, s = cos(transducer.yaw), sin(transducer.yaw)
    return c * dx + s * dy, c * dy - s * dx


@lru_cache(maxsize=64)
def _centres(first: float, resolution: float, count: int) -> Floats:
    """(n,) m: of so many cells in a row, the first of which begins there."""
    return first + (np.arange(count, dtype=np.float64) + 0.5) * resolution


def _bounds(
    transducer: Pose, half_angle: float, reach: float, resolution: float
) -> tuple[float, float, float, float]:
    """West, south, east and north of the cone, half a cell wider."""
    first, last = transducer.yaw - half_angle, transducer.yaw + half_angle
    x, y = reach * cos(first), reach * sin(first)
    to_x, to_y = reach * cos(last), reach * sin(last)
    west, south, east, north = min(x, to_x, 0.0), min(y, to_y, 0.0), max(x, to_x, 0.0), max(y, to_y, 0.0)
    for axis in range(ceil(first / _QUARTER), floor(last / _QUARTER) + 1):
        match axis % 4:
            case 0:
                east = reach
            case 1:
                north = reach
            case 2:
                west = -reach
            case _:
                south = -reach
    half = resolution / 2.0
    x, y = transducer.x, transducer.y
    return x + west - half, y + south - half, x + east + half, y + north + half
