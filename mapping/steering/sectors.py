"""Directions cut into sectors: a circle of numbers, counter-clockwise.

Sector k of n points to k alpha, alpha = 2 pi/n, in the grid's frame.
"""

from dataclasses import dataclass
from math import tau

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Opening:
    """Sectors in a row that are free."""

    right: int
    """The first, in 0...n - 1."""
    left: int
    """The last, counter-clockwise from the first: n and more beyond the circle's seam."""

    @property
    def width(self) -> int:
        """From border to border, in sectors."""
        return self.left - self.right


def apart(one: float, other: float, sectors: int) -> float:
    """How many sectors lie between two, the short way round: min(|a - b|, n - |a - b|)."""
    difference = abs(one - other) % sectors
    return min(difference, sectors - difference)


def openings(blocked: Mask) -> list[Opening]:
    """What is free between what is blocked; empty if nothing is blocked, or all."""
    before, after = np.concatenate([blocked[-1:], blocked[:-1]]), np.concatenate([blocked[1:], blocked[:1]])
    rights = np.flatnonzero(before & ~blocked).tolist()
    lefts = np.flatnonzero(after & ~blocked).tolist()
    if lefts and lefts[0] < rights[0]:
        lefts.append(lefts.pop(0) + len(blocked))
    return [Opening(right, left) for right, left in zip(rights, lefts, strict=True)]


def ring_sum(values: Floats, weights: Floats) -> Floats:
    """(n,) of each sector: the weighted sum of itself and its neighbours; the weights are odd in number."""
    half = len(weights) // 2
    around = np.concatenate([values[len(values) - half :], values, values[:half]])
    return np.convolve(around, weights, "valid")


def totals(sector: Indices, weights: Floats, sectors: int) -> Floats:
    """(n,) the sum of the weights in each sector."""
    return np.bincount(sector, weights, sectors).astype(np.float64)


def to_sectors(angle: float, sectors: int) -> float:
    """An angle (rad) in sectors, 0...n."""
    return angle / tau * sectors % sectors
