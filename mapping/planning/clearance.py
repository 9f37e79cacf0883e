"""How far each cell is from the next obstacle."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Squares = NDArray[np.unsignedinteger]


def squares(obstacles: NDArray[np.bool_], most: int) -> Squares:
    """(rows, cols) the square of the cells from each middle to that of the nearest obstacle.

    Exact up to most^2; (most + 1)^2 beyond. By rows, then by columns:
    d^2 = min over dr of (nearest in row r + dr)^2 + dr^2.
    """
    rows, cols = obstacles.shape
    width, far = cols + most, (most + 1) ** 2
    # Numbers no wider than the sums need, one row after the other, each with a margin of what is far: so
    # that every step is a pass over one plain stretch of memory.
    plain = np.full((rows, width), far, np.min_scalar_type(far + most**2))
    plain[:, :cols][obstacles] = 0
    by_rows = _lowered(plain.ravel(), [(step, step**2) for step in range(1, most + 1)])
    squared = _lowered(by_rows, [(step * width, step**2) for step in range(1, most + 1)])
    nearest: Squares = np.minimum(squared.reshape(rows, width)[:, :cols], plain.dtype.type(far))
    return nearest


def _lowered(plain: Squares, steps: list[tuple[int, int]]) -> Squares:
    """(n,) the least of each number and of its neighbours so many places off, plus what that costs."""
    least = plain.copy()
    for apart, cost in steps:
        offered = plain + plain.dtype.type(cost)
        np.minimum(least[apart:], offered[:-apart], out=least[apart:])
        np.minimum(least[:-apart], offered[apart:], out=least[:-apart])
    return least


@lru_cache(maxsize=16)
def roots(most: int) -> NDArray[np.float64]:
    """((most + 1)^2 + 1,) cells by their square; inf beyond `most`."""
    found = np.sqrt(np.arange((most + 1) ** 2 + 1, dtype=np.float64))
    found[most**2 + 1 :] = np.inf
    found.flags.writeable = False
    return found


def clearance(obstacles: NDArray[np.bool_], most: int) -> NDArray[np.float64]:
    """(rows, cols) cells from each middle to that of the nearest obstacle: exact up to `most`, else inf."""
    return roots(most).take(squares(obstacles, most))
