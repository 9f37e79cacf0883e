"""Calibrated evidence: a probability of 0.8 is to be right eight times in ten.

Beyond the book, whose maps are over-confident: each ping counts there as if it were independent of others.
Here a few statistics are kept of each cell (evidence.py), and two small networks, learned in emulated worlds
whose truth is known, say what they are worth: the first looks at the cell and its neighbours, the second at
how the first one saw the surroundings, too.
"""

from functools import cache
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.evidence import CellEvidence
from echogrid.mapping.evidence_features import context_features, own_features
from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.network import Floats, Network
from echogrid.mapping.sounding import Sounding

SUREST = 6.0
"""nats: what the first network says is kept within these bounds."""


class Judge(NamedTuple):
    """The two networks."""

    own: Network
    context: Network

    def log_odds(self, evidence: CellEvidence) -> Floats:
        """(rows, cols) of occupied; 0 where no echo has spoken."""
        known = spoken_of(evidence)
        features = own_features(evidence.statistics, evidence.geometry.resolution)
        first = np.zeros(evidence.geometry.shape)
        first[known] = np.clip(self.own.log_odds(features[known]), -SUREST, SUREST)
        surroundings = context_features(first, evidence.geometry.resolution)[known]
        result = np.zeros_like(first)
        result[known] = self.context.log_odds(np.concatenate((features[known], surroundings), axis=-1))
        return result


def spoken_of(evidence: CellEvidence) -> NDArray[np.bool_]:
    """(rows, cols) where at least one echo has spoken; silence alone tells too little."""
    statistics = evidence.statistics
    return (statistics.hit > 0) | (statistics.miss > 0) | (statistics.best > 0)


@cache
def shipped() -> Judge:
    """The networks that ship with the program."""
    from echogrid.mapping.calibrated_weights import CONTEXT, OWN

    return Judge(Network.of(OWN), Network.of(CONTEXT))


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
