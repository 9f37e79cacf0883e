"""How good probabilities are, against the truth: (n,) P(Occupied) of the judged cells, and (n,) which are.

Murphy, Introduction to AI Robotics, 11.6, has the first of them; the others say what it can't: whether a map
ranks walls above floor, and whether its probabilities are what they say.
"""

from math import log

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

NATS_IN_A_BIT = log(2.0)
FLAT = 1e-6
"""Probabilities that differ by less are the same: what is left of them is rounding."""


def book_score(probability: Floats, occupied: Mask) -> float:
    """Sum |truth - grid| (11.16), the truth being 1 where occupied; low is better."""
    return float(np.abs(occupied - probability).sum())


def log_loss(probability: Floats, occupied: Mask) -> float:
    """-mean(t ln p + (1 - t) ln(1 - p)), nats a cell; infinite if a cell was thought impossible."""
    with np.errstate(divide="ignore"):
        return float(-np.log(np.where(occupied, probability, 1.0 - probability)).mean())


def base_log_loss(occupied: Mask) -> float:
    """The log-loss, nats, of a map that knows no more than which part of all cells is occupied."""
    part = float(occupied.mean())
    return -sum(each * log(each) for each in (part, 1.0 - part) if each)


def skill(probability: Floats, occupied: Mask) -> float:
    """1 - log-loss/base log-loss: 1 is the truth, below 0 worse than no map; NaN if all cells are alike."""
    base = base_log_loss(occupied)
    return 1.0 - log_loss(probability, occupied) / base if base else np.nan


def brier(probability: Floats, occupied: Mask) -> float:
    """The mean of the squared errors."""
    return float(((occupied - probability) ** 2).mean())


def area_under_curve(probability: Floats, occupied: Mask) -> float:
    """AUC: how often an occupied cell is thought likelier to be so than a free one, a tie counting half.

    NaN if all cells are alike.
    """
    inside, outside = _by_value(probability, occupied)
    pairs = float(inside.sum() * outside.sum())
    below = np.cumsum(outside) - outside
    return float((inside * (below + outside / 2.0)).sum()) / pairs if pairs else np.nan


def average_precision(probability: Floats, occupied: Mask) -> float:
    """AP: the precision at each threshold, weighted by the recall it adds; NaN if no cell is occupied."""
    inside, outside = (counts[::-1] for counts in _by_value(probability, occupied))
    total = float(inside.sum())
    precision = np.cumsum(inside) / np.cumsum(inside + outside)
    return float((inside * precision).sum()) / total if total else np.nan


def calibration_error(probability: Floats, occupied: Mask, bins: int = 10) -> float:
    """ECE: how far a bin's mean probability is from its part that is occupied, on the mean over cells."""
    which = np.minimum((probability * bins).astype(np.intp), bins - 1)
    excess = np.bincount(which, occupied - probability, bins)
    return float(np.abs(excess).sum() / len(probability))


def correlation(probability: Floats, occupied: Mask) -> float:
    """Pearson's r between map and truth; 0 if one of them is the same everywhere, a map to within `FLAT`."""
    if float(np.ptp(probability)) < FLAT or occupied.all() or not occupied.any():
        return 0.0
    together = float(((probability - probability.mean()) * (occupied - occupied.mean())).mean())
    return together / float(probability.std() * occupied.std())


def map_score(probability: Floats, occupied: Mask) -> float:
    """Sum 1 + log2(p t + (1 - p)(1 - t)), bits over a map that knows nothing (Martin & Moravec 1996)."""
    return len(probability) * (1.0 - log_loss(probability, occupied) / NATS_IN_A_BIT)


def _by_value(probability: Floats, occupied: Mask) -> tuple[Floats, Floats]:
    """How many occupied and free cells have each probability, from the lowest to the highest."""
    values, which = np.unique(probability, return_inverse=True)
    total = np.bincount(which, minlength=len(values)).astype(np.float64)
    inside = np.bincount(which[occupied], minlength=len(values)).astype(np.float64)
    return inside, total - inside
