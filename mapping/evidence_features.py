"""What the networks are told of a cell: its statistics, its neighbours', and how like a wall it all is."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from echogrid.mapping.evidence import MILLI, NORMALS, Statistics

Floats = NDArray[np.float64]

_USUAL = 0.1
"""m: the cells with which it was learned."""
_HIT, _MISS = 0.05, 0.15
_NEVER = 6.0
"""m: a cell that was never hit counts as hit from so far."""
_REGION = 4
"""Cells to either side within which is told how much has been heard at all."""
_TANGENT = 4
"""Cells to either side to which echoes of one wall are summed along it."""
_PIECE = 3
"""Cells to either side that a short piece of wall has."""
_REACHES = 3, 6, 12
"""Cells to which it is looked along a wall, one way and the other,"""
_ASIDE = 2
"""and in so many of them across it."""
_QUARTER = NORMALS // 2


def own_features(s: Statistics, resolution: float) -> Floats:
    """(rows, cols, n) of each cell, with sides of `resolution` (m), and its neighbours.

    They mean the same whatever the resolution: of smaller cells more are looked at, and each has a smaller
    share of an echo.
    """
    finer = _finer(resolution)
    hit, miss, silent = (each / MILLI for each in (s.hit, s.miss, s.silent))
    shares = s.share / MILLI * (_USUAL / resolution) ** 2
    share = shares.sum(axis=0)
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
    columns += _tangents(shares, miss, finer)
    return np.stack([column.astype(np.float64) for column in columns], axis=-1)


def context_features(log_odds: Floats, resolution: float) -> Floats:
    """(rows, cols, m) of the surroundings, given how likely each cell seemed so far.

    A wall is a line, in the direction in which the log-odds are highest; it ends, or goes on. Their means are
    told around the cell; along the wall to the surer and the less sure side, to several reaches; along the
    two best lines, of each the less sure side; across the wall; and along short pieces of line.
    """
    finer = _finer(resolution)
    rays = _rays(log_odds, [reach * finer for reach in _REACHES])
    wall = (rays[1][:NORMALS] + rays[1][NORMALS:]).argmax(axis=0)
    columns = [log_odds, *(_sum(log_odds, reach, finer) / (2 * reach + 1) ** 2 for reach in (1, 2, 4))]
    for number, each in enumerate(rays):
        columns += _both_sides(each, wall)
        columns += _two_highest(np.minimum(each[:NORMALS], each[NORMALS:]))
        if number < _ASIDE:
            columns += _both_sides(each, wall + _QUARTER)
    pieces = np.array([_line(log_odds, turn, _PIECE * finer) for turn in range(NORMALS)])
    return np.stack([*columns, *_two_highest(pieces), pieces.min(axis=0)], axis=-1)


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


def _tangents(shares: Floats, miss: Floats, finer: int) -> list[Floats]:
    """What walls claim of echoes that came at right angles to them.

    An echo comes from where its arc touches the wall. So along a wall claims of one direction lie in a line,
    and where arcs only cross they do not.
    """
    cells = 2 * _TANGENT + 1
    sums = cells * np.array([_line(shares[n], n + _QUARTER, _TANGENT * finer) for n in range(NORMALS)])
    misses = cells * np.array([_line(miss, n + _QUARTER, _TANGENT * finer) for n in range(NORMALS)])
    best = sums.argmax(axis=0)
    highest = _at(sums, best)
    return [
        np.log1p(highest),
        np.log1p(_at(sums, best + _QUARTER)),
        np.log((highest + _HIT) / (_at(misses, best) + _MISS)),
        np.log1p(sums.sum(axis=0)),
    ]


def _line(values: Floats, turn: int, reach: int) -> Floats:
    """The means along pieces of line of 2 `reach` + 1 cells, so many times 22.5 deg off the x axis."""
    total = values.copy()
    padded = np.pad(values, reach)
    for step in (*range(-reach, 0), *range(1, reach + 1)):
        total += _moved(padded, reach, turn, step)
    return total / (2 * reach + 1)


def _rays(values: Floats, reaches: Sequence[int]) -> list[Floats]:
    """For each reach (16, rows, cols): the means of so many cells beside a cell, in directions all around."""
    margin = reaches[-1]
    padded, total = np.pad(values, margin), np.zeros((2 * NORMALS, *values.shape))
    means = []
    for before, reach in pairwise((0, *reaches)):
        for step in range(before + 1, reach + 1):
            for turn in range(2 * NORMALS):
                total[turn] += _moved(padded, margin, turn, step)
        means.append(total / reach)
    return means


def _moved(padded: Floats, margin: int, turn: int, step: int) -> Floats:
    """What lies so many cells away; `padded` is wider by the margin on each side."""
    angle = turn * np.pi / NORMALS
    row, col = margin + round(step * np.sin(angle)), margin + round(step * np.cos(angle))
    rows, cols = padded.shape
    return padded[row : row + rows - 2 * margin, col : col + cols - 2 * margin]


def _both_sides(rays: Floats, turn: NDArray[np.intp]) -> list[Floats]:
    """The higher and the lower of the rays in a direction and against it."""
    ahead, behind = _at(rays, turn), _at(rays, turn + NORMALS)
    return [np.maximum(ahead, behind), np.minimum(ahead, behind)]


def _two_highest(values: Floats) -> list[Floats]:
    """Of values (n, rows, cols) the highest and the second of each cell."""
    highest, second = np.maximum(values[0], values[1]), np.minimum(values[0], values[1])
    for each in values[2:]:
        second = np.maximum(second, np.minimum(highest, each))
        highest = np.maximum(highest, each)
    return [highest, second]


def _at(values: Floats, index: NDArray[np.intp]) -> Floats:
    """(rows, cols) of values (n, rows, cols), each cell by its own index, which goes round."""
    taken: Floats = np.take_along_axis(values, index[np.newaxis] % len(values), axis=0)[0]
    return taken
