"""Shifting an array under a window that moves by whole cells."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Cell = TypeVar("Cell", bound=np.generic)


def shifted(array: NDArray[Cell], shift: tuple[int, int]) -> NDArray[Cell]:
    """The array as seen by a window which moved `shift` rows and columns up; new cells are 0."""
    result = np.zeros_like(array)
    (to_rows, from_rows), (to_cols, from_cols) = (
        _overlap(moved, size) for moved, size in zip(shift, array.shape, strict=True)
    )
    result[to_rows, to_cols] = array[from_rows, from_cols]
    return result


def _overlap(moved: int, size: int) -> tuple[slice, slice]:
    """Where to, and where from, along one axis."""
    kept = max(size - abs(moved), 0)
    if moved >= 0:
        return slice(0, kept), slice(size - kept, size)
    return slice(size - kept, size), slice(0, kept)
