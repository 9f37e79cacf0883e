"""The wave that runs out from the goal: what each cell costs from there (Dijkstra on eight neighbours)."""

from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

Cell = tuple[int, int]
"""Row and column."""
Floats = NDArray[np.float64]

_AROUND = [(down, right) for down in (-1, 0, 1) for right in (-1, 0, 1) if down or right]
_LENGTHS = np.array([[sqrt(2.0) if down and right else 1.0] for down, right in _AROUND])
_HALVES = [(step, 0.5 * length) for step, length in zip(_AROUND, _LENGTHS.ravel().tolist(), strict=True)]


def cost_to_go(weights: Floats, goal: Cell, until: Cell | None = None) -> Floats:
    """(rows, cols) what the way to the goal costs from each cell; inf where none leads.

    `weights` say what a cell's length costs in each cell, at least 1, inf where none may be; a step costs
    its length times the mean of both cells' weights. With `until` it ends as soon as that cell's cost is
    known: those that cost no more are right as well, the others' are upper bounds.

    No step costs less than 1. So whatever lies within 1 of the cheapest open cell is final, and the whole
    of it goes on at once (Dial's buckets, each one array).
    """
    rows, cols = weights.shape
    halves = np.pad(weights * 0.5, 1, constant_values=inf).ravel()
    offsets = np.array([[down * (cols + 2) + right] for down, right in _AROUND])
    cost = np.full(halves.shape, inf)
    start = (goal[0] + 1) * (cols + 2) + goal[1] + 1
    last = start if until is None else (until[0] + 1) * (cols + 2) + until[1] + 1
    cost[start] = 0.0 if halves[start] < inf else inf
    waiting = np.array([start])
    first = np.zeros(halves.shape, np.intp)
    while len(waiting):
        reached = cost.take(waiting)
        cheapest = reached.min()
        if cheapest == inf or (until is not None and cost[last] < cheapest):
            break
        near = reached < cheapest + 1.0
        front = _once(waiting.compress(near), first)
        there = offsets + front
        offered = halves.take(there)
        offered += halves.take(front)
        offered *= _LENGTHS
        offered += cost.take(front)
        better = offered < cost.take(there)
        improved = there[better]
        np.minimum.at(cost, improved, offered[better])
        waiting = np.concatenate((waiting.compress(~near), improved))
    return cost.reshape(rows + 2, cols + 2)[1:-1, 1:-1]


def _once(cells: NDArray[np.intp], scratch: NDArray[np.intp]) -> NDArray[np.intp]:
    """Each of the cells once."""
    order = np.arange(len(cells))
    scratch[cells] = order
    kept: NDArray[np.intp] = cells[scratch.take(cells) == order]
    return kept


def descent(cost: Floats, weights: Floats, start: Cell) -> list[Cell]:
    """The cells from `start` down to the goal; empty if none leads there."""
    if cost[start] == inf:
        return []
    way, here = [start], start
    while cost[here] > 0.0:
        here = _next(cost, weights, here)
        way.append(here)
    return way


def _next(cost: Floats, weights: Floats, here: Cell) -> Cell:
    """The neighbour by which the way costs least; of several the first."""
    rows, cols = cost.shape
    own, least, best = weights.item(here), inf, here
    for (down, right), half in _HALVES:
        row, col = here[0] + down, here[1] + right
        if 0 <= row < rows and 0 <= col < cols:
            through = cost.item(row, col) + half * (own + weights.item(row, col))
            if through < least:
                least, best = through, (row, col)
    return best
