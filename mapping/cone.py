"""The sonar's cone on a grid: which cells one ping speaks about, and how strongly.

Murphy, Introduction to AI Robotics, 11.2-11.3. A cell at distance r and angle alpha from the transducer's
axis is in region I if |r - s| <= tolerance (an echo at s: probably occupied), in region II if it is nearer
(probably empty), and in region III, about which the ping says nothing, elsewhere.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import cos, pi, sin, tan

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.ranger import Ranger, effective_tolerance
from echogrid.mapping.sounding import Sounding

Floats = NDArray[np.float64]


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
    near = np.maximum(farthest - distance, 0.0) / farthest
    central = np.maximum(half_angle - np.abs(bearing), 0.0) / half_angle
    result: Floats = (near + central) / 2.0
    return result


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
    inside = _inside(along, np.abs(across), ranger.half_angle, geometry.resolution)
    inside &= squared <= reach * reach
    # One-dimensional arrays are picked from several times as quickly as two-dimensional ones.
    (chosen,) = inside.ravel().nonzero()
    distance = np.sqrt(squared.take(chosen))
    return Cone(
        patch,
        geometry,
        _cells(geometry, patch, chosen),
        distance,
        np.abs(np.arctan2(across.take(chosen), along.take(chosen))),
        distance >= s - band if echo else np.zeros(len(chosen), np.bool_),
        echo,
        ranger,
        s,
    )


def _cells(geometry: GridGeometry, patch: Patch, chosen: NDArray[np.intp]) -> NDArray[np.intp]:
    """The grid's numbers of cells of a patch, by their numbers in it."""
    width = max(patch[1].stop - patch[1].start, 1)
    first = patch[0].start * geometry.cols + patch[1].start
    cells: NDArray[np.intp] = chosen // width * (geometry.cols - width) + chosen + first
    return cells


def _inside(along: Floats, across: Floats, half_angle: float, resolution: float) -> NDArray[np.bool_]:
    """Within the cone, or within half a cell of its axis: a cone narrower than a cell still has no holes."""
    inside: NDArray[np.bool_] = across <= np.maximum(along * tan(half_angle), resolution / 2.0)
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
    axes = [k * pi / 2.0 for k in range(4)]
    crossed = [axis for axis in axes if abs(wrap_angle(axis - transducer.yaw)) < half_angle]
    angles = [transducer.yaw - half_angle, transducer.yaw + half_angle, *crossed]
    xs = [transducer.x, *(transducer.x + reach * cos(angle) for angle in angles)]
    ys = [transducer.y, *(transducer.y + reach * sin(angle) for angle in angles)]
    half = resolution / 2.0
    return min(xs) - half, min(ys) - half, max(xs) + half, max(ys) + half
