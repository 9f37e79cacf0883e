"""Whether one theory is truly better than another, or only lucky with the worlds and the noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DRAWS = 10_000
_TAIL = 2.5
"""%: to either side of the interval."""


@dataclass(frozen=True, slots=True)
class Difference:
    """By how much a figure differs, one theory's less the other's."""

    mean: float
    low: float
    high: float
    """Of the 95 % interval."""
    p: float
    """Two-sided: how likely it is that there is no difference, or one of the other sign; never 0."""


def paired_bootstrap(one: Floats, other: Floats, seed: int = 1, draws: int = DRAWS) -> Difference:
    """The difference of two theories' figures in the same trials, (worlds, seeds) each.

    Seeds of one world are alike, so worlds are drawn (with replacement), and in each of them seeds: five laps
    through a world do not make it five worlds.
    """
    differences = one - other
    worlds, seeds = differences.shape
    random = np.random.default_rng(seed)
    drawn_worlds = random.integers(worlds, size=(draws, worlds, 1))
    drawn_seeds = random.integers(seeds, size=(draws, worlds, seeds))
    means = differences[drawn_worlds, drawn_seeds].mean(axis=(1, 2))
    tail = min(np.count_nonzero(means <= 0.0), np.count_nonzero(means >= 0.0))
    low, high = np.percentile(means, (_TAIL, 100.0 - _TAIL))
    return Difference(
        float(differences.mean()), float(low), float(high), min(2.0 * (tail + 1) / (draws + 1), 1.0)
    )
