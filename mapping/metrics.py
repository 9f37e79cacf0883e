"""How good a map of walls is, against the truth. Cells outside `judged` do not count.

What is said here of a map that calls cells occupied or empty, probability_scores.py says of probabilities.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]

FAR = 2
"""Cells: what is further from every wall is a phantom, and a wall so far from all found ones is missed."""


@dataclass(frozen=True, slots=True)
class MapQuality:
    """Scores of a thresholded map."""

    precision: float
    recall: float
    phantoms: float
    """The part of the cells called occupied which lie more than two cells from any wall."""
    missed: float
    """The part of the walls which lie more than two cells from any cell called occupied."""
    overlap: float
    """Intersection over union, cell by cell, without any tolerance."""

    @property
    def f1(self) -> float:
        """The harmonic mean of precision and recall."""
        both = self.precision + self.recall
        return 2.0 * self.precision * self.recall / both if both else 0.0


def within(mask: Mask, cells: int) -> Mask:
    """Cells no further than `cells` (Euclidean, centre to centre) from one that is set."""
    rows, cols = mask.shape
    padded = np.pad(mask, cells)
    result = np.zeros_like(mask)
    for down in range(-cells, cells + 1):
        for right in range(-cells, cells + 1):
            if down * down + right * right <= cells * cells:
                result |= padded[cells + down : cells + down + rows, cells + right : cells + right + cols]
    return result


def quality(occupied: Mask, walls: Mask, judged: Mask, tolerance: int = 1) -> MapQuality:
    """The scores of the cells called occupied, (rows, cols), a hit being within `tolerance` cells of a wall.

    A wall counts as found if a cell called occupied is within the tolerance of it.
    """
    called, true = occupied & judged, walls & judged
    return MapQuality(
        precision=_part(called & within(walls, tolerance), called),
        recall=_part(true & within(called, tolerance), true),
        phantoms=_part(called & ~within(walls, FAR), called),
        missed=_part(true & ~within(called, FAR), true),
        overlap=_part(called & true, called | true),
    )


def free_recall(empty: Mask, walls: Mask, judged: Mask) -> float:
    """The part of the free space that the map calls empty; what it does not know it does not call so."""
    free = judged & ~walls
    return _part(free & empty, free)


def _part(cells: Mask, of: Mask) -> float:
    return int(np.count_nonzero(cells)) / max(int(np.count_nonzero(of)), 1)
