"""The reflection map: of all that passed through a cell or ended in it, the part that ended in it.

Counting (Burgard and others): p = (h + a)/(h + m + a + b), with h the hits and m the misses, weighted by how
near the axis and how near the transducer the cell lay. It believes in a frequency, not in a product of
likelihoods: what is contradictory stays in between.
"""

from typing import Self

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.cone import Cone, Floats, cast
from echogrid.mapping.evidence import AXIS, MILLI, NEAREST
from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.sounding import Sounding

PRIOR_HIT = 0.05
"""a."""
PRIOR_MISS = 0.15
"""b: with nothing heard, one cell in four is occupied."""
FULL = 1 << 30
"""Milli-hits and milli-misses together, of a cell that has heard enough: both are halved."""


def weight(cone: Cone) -> Floats:
    """(n,) exp(-2 (alpha/8 deg)^2)/max(r, 0.3 m): what a hit or miss of each cell counts."""
    result: Floats = np.exp(-2.0 * (cone.bearing / AXIS) ** 2) / np.maximum(cone.distance, NEAREST)
    return result


def reflection(hits: Floats, misses: Floats) -> Floats:
    """(h + a)/(h + m + a + b)."""
    return (hits + PRIOR_HIT) / (hits + misses + PRIOR_HIT + PRIOR_MISS)


class CountingGrid:
    """Sums of weights, each rounded once to a thousandth.

    Sums of floating-point numbers depend on their order by rounding; sums of integers do not. So the same
    pings give the same bits in whatever order they came. Silence is ignored.
    """

    def __init__(self, geometry: GridGeometry) -> None:
        self.geometry = geometry
        self.hits: NDArray[np.int32] = np.zeros(geometry.shape, np.int32)
        """(rows, cols) milli-hits, row 0 = south."""
        self.misses: NDArray[np.int32] = np.zeros(geometry.shape, np.int32)
        """(rows, cols) milli-misses."""

    def update(self, sounding: Sounding) -> Patch | None:
        """Fuse one ping; the patch that it touched, None if it said nothing."""
        if sounding.echo is None:
            return None
        cone = cast(self.geometry, sounding)
        counted = np.rint(weight(cone) * MILLI).astype(np.int32)
        at = cone.rows, cone.cols
        self.hits[at] += np.where(cone.occupied, counted, 0)
        self.misses[at] += np.where(cone.occupied, 0, counted)
        self._age(at)
        return cone.patch if counted.any() else None

    def _age(self, at: tuple[NDArray[np.intp], NDArray[np.intp]]) -> None:
        """Halve what is full, so that no sum runs over, and no cell gets too old to change its mind."""
        full = self.hits[at].astype(np.int64) + self.misses[at] > FULL
        if full.any():
            these = at[0][full], at[1][full]
            self.hits[these] >>= 1
            self.misses[these] >>= 1

    def occupancy(self) -> NDArray[np.float32]:
        """(rows, cols) P(Occupied), row 0 = south; 0.5 where unknown."""
        found = reflection(self.hits / MILLI, self.misses / MILLI)
        return np.where(self.unknown(), 0.5, found).astype(np.float32)

    def unknown(self) -> NDArray[np.bool_]:
        """(rows, cols) True where no echo has spoken."""
        unheard: NDArray[np.bool_] = (self.hits == 0) & (self.misses == 0)
        return unheard

    def copy(self) -> Self:
        """An independent twin."""
        twin = type(self)(self.geometry)
        twin.hits, twin.misses = self.hits.copy(), self.misses.copy()
        return twin
