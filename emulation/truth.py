"""The true map of a world on the cells of a grid, to judge maps by."""

from math import hypot

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.world import World

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def truth(
    world: World, x_centres: FloatArray, y_centres: FloatArray, seed_point: tuple[float, float]
) -> tuple[BoolArray, BoolArray]:
    """Which cells hold a surface, and which are free and reachable: two (rows, columns) arrays.

    Rows follow y_centres, columns x_centres (m, map frame, evenly spaced). A cell is occupied when a surface
    comes within half of its diagonal; free are the other cells that connect to the one of the seed point.
    """
    x, y = np.meshgrid(x_centres, y_centres)
    half_diagonal = 0.5 * hypot(x_centres[1] - x_centres[0], y_centres[1] - y_centres[0])
    distances = world.surface_distance(np.column_stack((x.ravel(), y.ravel()))).reshape(x.shape)
    occupied = distances <= half_diagonal
    seed = np.abs(y_centres - seed_point[1]).argmin(), np.abs(x_centres - seed_point[0]).argmin()
    return occupied, _flood(~occupied, (int(seed[0]), int(seed[1])))


def _flood(passable: BoolArray, seed: tuple[int, int]) -> BoolArray:
    """The passable cells that connect to the seed through edges.

    Surfaces are thicker than the step between neighbours (half a diagonal to either side), so it cannot leak.
    """
    filled = np.zeros_like(passable)
    filled[seed] = passable[seed]
    before = 0
    while (count := int(np.count_nonzero(filled))) != before:
        before = count
        grown = filled.copy()
        grown[1:] |= filled[:-1]
        grown[:-1] |= filled[1:]
        grown[:, 1:] |= filled[:, :-1]
        grown[:, :-1] |= filled[:, 1:]
        filled = grown & passable
    return filled
