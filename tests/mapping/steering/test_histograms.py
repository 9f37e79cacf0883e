"""Each histogram against its twin, which is reckoned cell by cell from the equations."""

from math import inf

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.steering.goal import Goal
from echogrid.mapping.steering.vff import repulsions

from . import by_hand
from .scenes import WINDOW, Cell, beside, headings, method, view_of, worlds

AHEAD = Goal(0.0, inf)


@given(worlds)
def test_vfh_s_densities_are_those_of_the_equations(world: list[Cell]) -> None:
    density = method("vfh").steer(view_of(world), 0.0, AHEAD).polar.density
    assert density == approx(by_hand.vfh(world), abs=1e-6)


@given(worlds)
def test_vfh_plus_s_densities_are_exactly_those_of_the_equations(world: list[Cell]) -> None:
    density = method("vfh+").steer(view_of(world), 0.0, AHEAD).polar.density
    assert density.tolist() == by_hand.vfh_plus(world)


@given(worlds)
def test_vff_s_push_is_that_of_the_equations(world: list[Cell]) -> None:
    view = view_of(world)
    x, y = repulsions(view.certainty[view.hits], WINDOW.x[view.hits], WINDOW.y[view.hits], 0.05)
    assert (x.sum(), y.sum()) == approx(by_hand.vff(world, 0.05), abs=1e-9)


@pytest.mark.parametrize("name", ["vff", "vfh", "vfh+"])
@given(world=worlds, one_more=beside, bearing=headings, distance=st.floats(0.0, 5.0))
def test_an_obstacle_more_never_lowers_a_density(
    name: str, world: list[Cell], one_more: Cell, bearing: float, distance: float
) -> None:
    before = {(row, col): milli for row, col, milli in world}
    assume(before.get(one_more[:2], -2000) <= one_more[2])
    goal = Goal(bearing, distance)
    fewer = method(name).steer(view_of(world), 0.0, goal).polar.density
    more = method(name).steer(view_of([*world, one_more]), 0.0, goal).polar.density
    assert np.all(more >= fewer - 1e-9)


@given(worlds, st.floats(0.0, 3.0))
def test_what_stands_behind_the_goal_does_not_count(world: list[Cell], distance: float) -> None:
    reach = distance + WINDOW.keep
    nearer = [cell for cell in world if (cell[0] ** 2 + cell[1] ** 2) ** 0.5 * WINDOW.resolution <= reach]
    for name in ("vff", "vfh", "vfh+"):
        goal = Goal(0.0, distance)
        assert (
            method(name).steer(view_of(world), 0.0, goal).polar.density.tolist()
            == method(name).steer(view_of(nearer), 0.0, goal).polar.density.tolist()
        )
