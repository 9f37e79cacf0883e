"""The shortest way against a twin that knows no heap, and against what every way must obey."""

from itertools import product
from math import hypot, inf, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from echogrid.emulation.shortest_path import Floor, traced
from echogrid.emulation.worlds.arenas import ARENAS

RADIUS = 1.0
SMALL = arrays.arrays(np.bool_, (6, 7), elements=st.booleans())


def floor_of(free):
    """A floor with a border that nobody reaches."""
    return Floor(np.where(np.pad(free, 1), 2.0 * RADIUS, 0.0), RADIUS, 0.0, 0.0, 1.0)


def relaxed(free, start):
    """Bellman and Ford: every step again and again, until nothing gets shorter."""
    lengths = np.full(free.shape, inf)
    if free[start]:
        lengths[start] = 0.0
    changed = True
    while changed:
        changed = False
        for row, col in np.argwhere(free):
            for down, right in product((-1, 0, 1), repeat=2):
                length = lengths[row + down, col + right] + (sqrt(2.0) if down and right else 1.0)
                if (down or right) and length < lengths[row, col] - 1e-12:
                    lengths[row, col], changed = length, True
    return lengths


@given(SMALL, st.tuples(st.integers(1, 6), st.integers(1, 7)))
def test_lengths_are_those_of_a_search_without_a_queue(free, start):
    floor = floor_of(free)
    lengths, _ = floor.lengths_from(start)
    np.testing.assert_allclose(lengths, relaxed(np.pad(free, 1), start))


@given(SMALL, st.tuples(st.integers(1, 6), st.integers(1, 7)))
def test_a_tight_way_is_no_longer_than_that_on_the_grid_and_no_shorter_than_the_straight_one(free, start):
    floor = floor_of(free)
    lengths, before = floor.lengths_from(start)
    for row, col in np.argwhere(np.isfinite(lengths)):
        goal = int(row), int(col)
        way = traced(before, goal)
        assert way[0] == start
        assert all(floor.free[cell] for cell in way)
        tight = floor.tight([floor.middle(cell) for cell in way])
        straight = hypot(goal[0] - start[0], goal[1] - start[1])
        assert straight - 1e-9 <= tight <= lengths[goal] + 1e-9


def test_an_empty_floor_is_crossed_straight():
    floor = floor_of(np.ones((6, 7), np.bool_))
    _, before = floor.lengths_from((1, 1))
    tight = floor.tight([floor.middle(cell) for cell in traced(before, (6, 3))])
    assert tight == pytest.approx(hypot(5.0, 2.0))


def test_from_a_wall_no_way_leads_anywhere():
    lengths, before = floor_of(np.zeros((3, 3), np.bool_)).lengths_from((1, 1))
    assert np.isinf(lengths).all()
    assert before == {}


def test_a_door_is_passed_only_by_who_fits_through():
    arena = ARENAS["narrow-doors"]()
    goal = 10.5, 3.0
    for radius, fits in ((0.27, True), (0.4, False)):
        floor = Floor.of(arena.world, radius)
        lengths, _ = floor.lengths_from(floor.cell(arena.inside))
        assert np.isfinite(lengths[floor.cell(goal)]) == fits
