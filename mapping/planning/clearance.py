"""How far each cell is from the next obstacle."""

import numpy as np
from numpy.typing import NDArray


def clearance(obstacles: NDArray[np.bool_], most: int) -> NDArray[np.float64]:
    """(rows, cols) cells from each middle to that of the nearest obstacle: exact up to `most`, else inf.

    By rows, then by columns: d^2 = min over dr of (nearest in row r + dr)^2 + dr^2.
    """
    far = (most + 1) ** 2
    along = np.full(obstacles.shape, far, np.int32)
    along[obstacles] = 0
    by_rows = along.copy()
    for step in range(1, most + 1):
        _lower(by_rows[:, step:], along[:, :-step], step)
        _lower(by_rows[:, :-step], along[:, step:], step)
    squared = by_rows.copy()
    for step in range(1, most + 1):
        _lower(squared[step:], by_rows[:-step], step)
        _lower(squared[:-step], by_rows[step:], step)
    return np.where(squared <= most**2, np.sqrt(squared), np.inf)


def _lower(squared: NDArray[np.int32], neighbours: NDArray[np.int32], step: int) -> None:
    np.minimum(squared, neighbours + step**2, out=squared)
