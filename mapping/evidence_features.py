"""What the networks are told of a cell: its statistics, its neighbours', and how like a wall it all is."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from echogrid.mapping.evidence import MILLI, Statistics

Floats = NDArray[np.float64]

_USUAL = 0.1
"""m: the cells with which it was learned."""
_HIT, _MISS = 0.05, 0.15
_NEVER = 6.0
"""m: a cell that was never hit counts as hit from so far."""
_REGION = 4
"""Cells to either side within which is told how much has been heard at all."""
_ALONG = 3
"""Cells to either side that a piece of wall has."""
_ANGLES = 8


def own_features(s: Statistics, resolution: float) -> Floats:
    """(rows, cols, n) of each cell, with sides of `resolution` (m), and its neighbours.

    They mean the same whatever the resolution: of smaller cells more are looked at, and each has a smaller
    share of an echo.
    """
    finer = _finer(resolution)
    hit, miss, silent, share = (each / MILLI for each in (s.hit, s.miss, s.silent, s.share))
    share = share * (_USUAL / resolution) ** 2
    nearest = np.where(s.nearest > 0, np.minimum(s.nearest / MILLI, _NEVER), _NEVER)
    columns = [
        np.log1p(hit),
        np.log1p(miss),
        np.log1p(silent),
        np.bitwise_count(s.hit_from),
        np.bitwise_count(s.missed_from),
        s.best / MILLI,
        nearest,
        np.log1p(s.clearest / MILLI),
        np.log((hit + _HIT) / (miss + _MISS)),
        np.log((share + _HIT) / (miss + _MISS)),
        np.log1p(share),
    ]
    for reach in (1, 2):
        near_hit, near_miss, near_share = (_sum(each, reach, finer) for each in (hit, miss, share))
        columns.append(np.log((near_hit + _HIT) / (near_miss + _MISS)))
        columns.append(np.log1p(near_share))
    columns.append(np.log1p(_sum(hit + miss, _REGION, finer)))
    return np.stack([column.astype(np.float64) for column in columns], axis=-1)


def context_features(log_odds: Floats, resolution: float) -> Floats:
    """(rows, cols, m) of the surroundings, given how likely each cell seemed by itself.

    A wall is a line: the means of the log-odds along pieces of line in eight directions, the highest, the
    second, the one across the highest and the lowest; and the means around.
    """
    finer = _finer(resolution)
    means = _along(log_odds, _ALONG * finer)
    order = np.sort(means, axis=0)
    across = (means.argmax(axis=0) + _ANGLES // 2) % _ANGLES
    columns = [
        log_odds,
        order[-1],
        order[-2],
        np.take_along_axis(means, across[np.newaxis], axis=0)[0],
        order[0],
        *(_sum(log_odds, reach, finer) / (2 * reach + 1) ** 2 for reach in (1, 2, 4)),
    ]
    return np.stack(columns, axis=-1)


def around(values: Floats, reach: int) -> Floats:
    """The sums over the squares of 2 `reach` + 1 cells a side."""
    padded = np.pad(values, reach)
    side = 2 * reach + 1
    rows = sliding_window_view(padded, side, axis=0).sum(axis=-1)
    result: Floats = sliding_window_view(rows, side, axis=1).sum(axis=-1)
    return result


def _finer(resolution: float) -> int:
    """How many cells there are to a side of a usual one."""
    return max(1, round(_USUAL / resolution))


def _sum(values: Floats, reach: int, finer: int) -> Floats:
    """What `around` would be with usual cells: the mean over as large a square, times its usual cells."""
    return around(values, reach * finer) * ((2 * reach + 1) / (2 * reach * finer + 1)) ** 2


def _along(values: Floats, reach: int) -> Floats:
    """(8, rows, cols) the means along pieces of line of 2 `reach` + 1 cells."""
    rows, cols = values.shape
    padded = np.pad(values, reach)
    means = []
    for angle in np.arange(_ANGLES) * np.pi / _ANGLES:
        total = np.zeros_like(values)
        for step in range(-reach, reach + 1):
            down, right = round(step * np.sin(angle)), round(step * np.cos(angle))
            total += padded[reach + down : reach + down + rows, reach + right : reach + right + cols]
        means.append(total / (2 * reach + 1))
    return np.array(means)
