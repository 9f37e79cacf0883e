import heapq
from itertools import pairwise
from math import inf, sqrt

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pytest import approx

from echogrid.mapping.planning.wavefront import cost_to_go, descent

Cell = tuple[int, int]
costs = st.one_of(st.just(1.0), st.just(inf), st.floats(1.0, 30.0))
shapes = st.tuples(st.integers(1, 9), st.integers(1, 9))


@st.composite
def plains(draw: st.DrawFn) -> tuple[np.ndarray, Cell, Cell]:
    """What the cells cost, a goal and another cell."""
    shape = draw(shapes)
    cell = st.tuples(st.integers(0, shape[0] - 1), st.integers(0, shape[1] - 1))
    return draw(arrays(np.float64, shape, elements=costs)), draw(cell), draw(cell)


def dijkstra(weights: np.ndarray, goal: Cell) -> np.ndarray:
    """The same, one cell at a time."""
    cost = np.full(weights.shape, inf)
    if weights[goal] == inf:
        return cost
    cost[goal] = 0.0
    queue = [(0.0, goal)]
    while queue:
        so_far, here = heapq.heappop(queue)
        for row in range(max(here[0] - 1, 0), min(here[0] + 2, weights.shape[0])):
            for col in range(max(here[1] - 1, 0), min(here[1] + 2, weights.shape[1])):
                length = sqrt(abs(row - here[0]) + abs(col - here[1]))
                offered = so_far + length * (weights[here] + weights[row, col]) / 2.0
                if offered < cost[row, col]:
                    cost[row, col] = offered
                    heapq.heappush(queue, (offered, (row, col)))
    return cost


@settings(deadline=None)
@given(plains())
def test_it_costs_what_dijkstra_says_cell_by_cell(plain: tuple[np.ndarray, Cell, Cell]) -> None:
    weights, goal, _ = plain
    np.testing.assert_allclose(cost_to_go(weights, goal), dijkstra(weights, goal), rtol=1e-12)


@settings(deadline=None)
@given(plains())
def test_ending_early_changes_no_cost_up_to_that_of_the_cell(plain: tuple[np.ndarray, Cell, Cell]) -> None:
    weights, goal, until = plain
    early, whole = cost_to_go(weights, goal, until), cost_to_go(weights, goal)
    assert early[until] == whole[until]
    assert np.array_equal(early[whole <= whole[until]], whole[whole <= whole[until]])
    assert (early >= whole).all()


@settings(deadline=None)
@given(plains())
def test_the_way_down_costs_what_was_said(plain: tuple[np.ndarray, Cell, Cell]) -> None:
    weights, goal, start = plain
    cost = cost_to_go(weights, goal, start)
    way = descent(cost, weights, start)
    assert bool(way) == (cost[start] < inf)
    if way:
        assert (way[0], way[-1]) == (start, goal)
        spent = 0.0
        for here, there in pairwise(way):
            moved = abs(there[0] - here[0]), abs(there[1] - here[1])
            assert max(moved) == 1
            spent += sqrt(sum(moved)) * (weights[here] + weights[there]) / 2.0
        assert spent == approx(cost[start])


def test_a_worked_example_goes_round_the_walls() -> None:
    plan = ["#########", "#...#...#", "#.#.#.#.#", "#.#...#.#", "#########"]
    weights = np.array([[inf if cell == "#" else 1.0 for cell in row] for row in plan])
    cost = cost_to_go(weights, (3, 1))
    assert cost[1, 3] == approx(2.0 + sqrt(2.0))
    assert cost[3, 7] == approx(2.0 + 6.0 * sqrt(2.0))
    assert cost[0, 0] == inf
