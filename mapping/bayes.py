"""Bayes' grid: per cell the sum of log-odds, as saturating int16 milli-nats."""

from typing import Self

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.cone import Cone, cast
from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.rolling import shifted
from echogrid.mapping.sonar_model import NoEcho, SonarModel, evidence
from echogrid.mapping.sounding import Sounding

MILLI = 1000.0
"""Milli-nats in a nat."""


class BayesGrid:
    """Recursive Bayes (11.6) with prior 1/2: independent evidence adds in log-odds.

    Evidence is quantised once, so that sums of integers give the same bits everywhere; they saturate at
    `limit` nats on both sides, from where a few contrary pings lead back. A cell about which no ping
    has spoken is unknown, which is not the same as undecided.
    """

    def __init__(self, geometry: GridGeometry, limit: float, model: SonarModel, no_echo: NoEcho) -> None:
        self.geometry = geometry
        self.log_odds: NDArray[np.int16] = np.zeros(geometry.shape, np.int16)
        """(rows, cols) milli-nats, row 0 = south."""
        self._seen: NDArray[np.bool_] = np.zeros(geometry.shape, np.bool_)
        self._limit = round(limit * MILLI)
        self._model = model
        self._no_echo = no_echo

    def update(self, sounding: Sounding) -> Patch | None:
        """Fuse one ping; the patch that it touched, None if it said nothing."""
        cone = cast(self.geometry, self._model.believed(sounding))
        return cone.patch if len(self.fuse(cone)) else None

    def fuse(self, cone: Cone) -> NDArray[np.intp]:
        """Fuse one ping; the cells of which it spoke, as row * columns + column."""
        return self.add(cone.cells, self.weigh(cone))

    def weigh(self, cone: Cone) -> NDArray[np.int32]:
        """(n,) milli-nats that a ping is worth to each of its cone's cells."""
        return np.rint(evidence(cone, self._model, self._no_echo) * MILLI).astype(np.int32)

    def add(self, cells: NDArray[np.intp], milli_nats: NDArray[np.int32]) -> NDArray[np.intp]:
        """Add evidence to cells, each of which comes once; those that got any."""
        (speaks,) = milli_nats.nonzero()
        cells = cells.take(speaks)
        total = self.log_odds.take(cells) + milli_nats.take(speaks)
        self.log_odds.put(cells, np.minimum(np.maximum(total, -self._limit), self._limit))
        self._seen.put(cells, True)
        return cells

    def fade(self, factor: float) -> None:
        """Let all evidence fade towards nothing."""
        np.copyto(self.log_odds, np.fix(self.log_odds * factor), casting="unsafe")

    def move(self, geometry: GridGeometry, shift: tuple[int, int]) -> None:
        """Lay the grid over another place, `shift` rows and columns further; new cells are unknown."""
        self.geometry = geometry
        self.log_odds = shifted(self.log_odds, shift)
        self._seen = shifted(self._seen, shift)

    def occupancy(self) -> NDArray[np.float32]:
        """(rows, cols) P(Occupied), row 0 = south; 0.5 where unknown."""
        return probability(self.log_odds)

    def unknown(self) -> NDArray[np.bool_]:
        """(rows, cols) True where no ping has spoken."""
        return ~self._seen

    def copy(self) -> Self:
        """An independent twin."""
        twin = type(self)(self.geometry, self._limit / MILLI, self._model, self._no_echo)
        twin.log_odds, twin._seen = self.log_odds.copy(), self._seen.copy()
        return twin


def probability(log_odds: NDArray[np.int16]) -> NDArray[np.float32]:
    """P(Occupied) of milli-nats."""
    return (1.0 / (1.0 + np.exp(log_odds / -MILLI))).astype(np.float32)
