"""How good a map is, against the truth. Cells outside `judged` do not count."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class MapQuality:
    """Scores of a thresholded map."""

    precision: float
    recall: float
    phantoms: float
    """The part of the cells called occupied which lie more than two cells from any wall."""

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
    hits = called & within(walls, tolerance)
    found = true & within(called, tolerance)
    phantoms = called & ~within(walls, 2)
    return MapQuality(
        _part(hits, called),
        _part(found, true),
        _part(phantoms, called),
    )


def _part(cells: Mask, of: Mask) -> float:
    return int(np.count_nonzero(cells)) / max(int(np.count_nonzero(of)), 1)
