"""Calibrated evidence: a probability of 0.8 is to be right eight times in ten.

Beyond the book, whose maps are over-confident: each ping counts there as if it were independent of others.
Here a few statistics are kept of each cell (evidence.py), and small networks, learned in emulated worlds
whose truth is known, say what they are worth: the first looks at the cell and its neighbours, the second also
at how the first one saw the surroundings, and the third at how the second did.
"""

from functools import cache
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.evidence import CellEvidence, Statistics
from echogrid.mapping.evidence_features import context_features, own_features
from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.network import Floats, Network
from echogrid.mapping.sounding import Sounding

SUREST = 6.0
"""nats: what a network says is kept within these bounds for the next."""


class Judge(NamedTuple):
    """The networks."""

    own: Network
    context: Network
    again: Network

    def log_odds(self, evidence: CellEvidence) -> Floats:
        """(rows, cols) of occupied; 0 where no echo has spoken."""
        result, everywhere = np.zeros(evidence.geometry.shape), spoken_of(evidence)
        if not everywhere.any():
            return result
        box, resolution = _bounds(everywhere), evidence.geometry.resolution
        known, said = everywhere[box], result[box]
        statistics = Statistics._make(each[(..., *box)] for each in evidence.statistics)
        told = own_features(statistics, resolution)[known]
        said[known] = self.own.log_odds(told)
        for network in (self.context, self.again):
            said[known] = network.log_odds(in_context(told, known, said, resolution))
        return result


def in_context(told: Floats, known: NDArray[np.bool_], log_odds: Floats, resolution: float) -> Floats:
    """(n, m) what is told of each of the n known cells, and how a network saw its surroundings."""
    surroundings = context_features(np.clip(log_odds, -SUREST, SUREST), resolution)
    return np.concatenate((told, surroundings[known]), axis=-1)


def spoken_of(evidence: CellEvidence) -> NDArray[np.bool_]:
    """(rows, cols) where at least one echo has spoken; silence alone tells too little."""
    statistics = evidence.statistics
    return (statistics.hit > 0) | (statistics.miss > 0) | (statistics.best > 0)


def _bounds(known: NDArray[np.bool_]) -> Patch:
    """The smallest patch that holds all known cells: beyond it there is nothing to be told."""
    rows, cols = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(cols[0]), int(cols[-1]) + 1)


@cache
def shipped() -> Judge:
    """The networks that ship with the program."""
    from echogrid.mapping.calibrated_weights import AGAIN, CONTEXT, OWN

    return Judge(Network.of(OWN), Network.of(CONTEXT), Network.of(AGAIN))


class CalibratedGrid:
    """A theory that keeps statistics, and judges them when it is asked."""

    def __init__(self, geometry: GridGeometry, judge: Judge | None = None) -> None:
        """Without a judge it takes the shipped one."""
        self.geometry = geometry
        self.evidence = CellEvidence(geometry)
        self._judge = judge or shipped()

    def update(self, sounding: Sounding) -> Patch | None:
        """Fuse one ping; the patch that it touched, None if it said nothing."""
        return self.evidence.add(sounding)

    def occupancy(self) -> NDArray[np.float32]:
        """(rows, cols) P(Occupied), row 0 = south; 0.5 where unknown."""
        return (1.0 / (1.0 + np.exp(-self._judge.log_odds(self.evidence)))).astype(np.float32)

    def unknown(self) -> NDArray[np.bool_]:
        """(rows, cols) True where no echo has spoken."""
        return ~spoken_of(self.evidence)

    def copy(self) -> Self:
        """An independent twin."""
        twin = type(self)(self.geometry, self._judge)
        twin.evidence = self.evidence.copy()
        return twin
