"""The straight faces of a map's walls: where an echo comes from, at the foot of the perpendicular."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.metrics import Mask

Floats = NDArray[np.float64]

RADIUS = 0.5
"""m: a face's direction is that of its cells so far around."""
_FEWEST_CELLS = 4
"""The same in cells, at least: a coarse map's steps would turn it."""
_ROUGHEST = 0.6
"""Cells, standard deviation across the face: a straight wall at a slant has steps of 0.3 to 0.5."""
_SHORTEST = 0.4
"""The standard deviation along it over the radius; of a wall that goes on at both sides it is 0.58."""
_MOST_TURNED = 0.6
"""The cosine between its normal and the side on which it is free; 45 degrees have 0.71."""
_SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1))
"""Rows and columns from a cell to its neighbours."""


@dataclass(frozen=True, slots=True)
class WallFaces:
    """Faces of n cells, in the map's frame; m. A cell that is free on two sides may have two."""

    geometry: GridGeometry
    solid: Floats
    """(m, 2) the centres of all cells that are occupied, with a face or without."""
    cells: Floats
    """(n, 2) the centres of the cells that have a face."""
    middles: Floats
    """(n, 2) a point on the line through the face's cells around."""
    normals: Floats
    """(n, 2) unit vectors to the free side."""


def faces_of(geometry: GridGeometry, occupied: Mask) -> WallFaces:
    """The faces of a map's occupied cells (rows, cols) towards all others.

    Each side is looked at by itself, or the two faces of a thin wall would be taken for one between them.
    """
    beyond = np.pad(~occupied, 1, constant_values=True)
    rows, cols = geometry.shape
    parts = [
        _straight(geometry, occupied & beyond[1 + down : 1 + down + rows, 1 + right : 1 + right + cols], side)
        for side in _SIDES
        for down, right in (side,)
    ]
    solid = _centres(geometry, *np.nonzero(occupied))
    return WallFaces(geometry, solid, *(np.concatenate(each) for each in zip(*parts, strict=True)))


def _straight(geometry: GridGeometry, edge: Mask, side: tuple[int, int]) -> tuple[Floats, Floats, Floats]:
    """Cells, middles and normals of those cells of an edge that lie in a straight line with their
    neighbours: by the principal axes of the cells around each."""
    reach = max(round(RADIUS / geometry.resolution), _FEWEST_CELLS)
    rows, cols = np.nonzero(edge)
    count, x, y, xx, xy, yy = _moments(edge, reach)[:, rows, cols]
    x, y = x / count, y / count
    xx, xy, yy = xx / count - x * x, xy / count - x * y, yy / count - y * y
    half, middle = np.hypot((xx - yy) / 2.0, xy), (xx + yy) / 2.0
    along = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    normals = np.stack((-np.sin(along), np.cos(along)), axis=1)
    towards = normals @ np.array((side[1], side[0]), np.float64)
    normals *= np.sign(towards)[:, np.newaxis]
    straight = np.sqrt(np.maximum(middle - half, 0.0)) < _ROUGHEST
    straight &= np.sqrt(middle + half) > _SHORTEST * reach
    straight &= np.abs(towards) > _MOST_TURNED
    centres = _centres(geometry, rows, cols)
    middles = centres + geometry.resolution * np.stack((x, y), axis=1)
    return centres[straight], middles[straight], normals[straight]


def _moments(edge: Mask, reach: int) -> Floats:
    """(6, rows, cols) sums of 1, x, y, xx, xy, yy over the edge's cells around each cell, in cells."""
    rows, cols = edge.shape
    padded = np.pad(edge.astype(np.float64), reach)
    sums = np.zeros((6, rows, cols))
    for down in range(-reach, reach + 1):
        for right in range(-reach, reach + 1):
            if down * down + right * right <= reach * reach:
                here = padded[reach + down : reach + down + rows, reach + right : reach + right + cols]
                powers = (1.0, right, down, right * right, right * down, down * down)
                for total, power in zip(sums, powers, strict=True):
                    total += power * here
    return sums


def _centres(geometry: GridGeometry, rows: NDArray[np.intp], cols: NDArray[np.intp]) -> Floats:
    """(n, 2) x and y of cells."""
    return np.stack((geometry.x_centres[cols], geometry.y_centres[rows]), axis=1)
