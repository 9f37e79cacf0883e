"""What must be true of every way of steering."""

import copy
from math import cos, isfinite, pi, sin, tau

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.steering.decision import Decision, Why
from echogrid.mapping.steering.goal import Goal, ahead, towards
from echogrid.mapping.steering.obstacles import Belief, Obstacles
from echogrid.mapping.steering.window import Window
from echogrid.mapping.unknown import Unknown

from .scenes import (
    METHODS,
    MIDDLE,
    NOW,
    WINDOW,
    Cell,
    cells,
    facing,
    headings,
    local_grid,
    method,
    speeds,
    view_of,
    within_cell,
    worlds,
)

pytestmark = pytest.mark.parametrize("name", METHODS)
finite = st.floats(allow_nan=False, allow_infinity=False, width=32)


def decide(name: str, world: list[Cell], yaw: float, bearing: float, speed: float = 0.0) -> Decision:
    return method(name).steer(view_of(world, facing(yaw)), speed, Goal(bearing))


def tied(decision: Decision) -> bool:
    """Whether another direction would have cost the same: then order decides."""
    costs = [candidate.cost for candidate in decision.candidates]
    return len(costs) > 1 and costs[1] - costs[0] < 1e-6


def same(one: float | None, other: float | None, turn: float = 0.0) -> bool:
    if one is None or other is None:
        return one is other
    return abs(wrap_angle(one + turn - other)) < 1e-6


@given(yaw=headings, speed=speeds, x=within_cell, y=within_cell, at_x=finite, at_y=finite)
def test_an_empty_world_is_driven_straight_to_the_goal(
    name: str, yaw: float, speed: float, x: float, y: float, at_x: float, at_y: float
) -> None:
    robot = facing(yaw, x, y)
    goal = towards(robot, at_x, at_y)
    decision = method(name).steer(view_of([], robot), speed, goal)
    assert decision.heading == goal.bearing
    assert (decision.factor, decision.why) == (1.0, Why.TARGET)


@given(world=worlds, yaw=headings, bearing=headings, speed=speeds, quarters=st.integers(1, 3))
def test_a_world_a_quarter_round_turns_the_decision_with_it(
    name: str, world: list[Cell], yaw: float, bearing: float, speed: float, quarters: int
) -> None:
    turned = world
    for _ in range(quarters):
        turned = [(col, -row, milli) for row, col, milli in turned]
    turn = quarters * pi / 2.0
    before = decide(name, world, yaw, bearing, speed)
    after = decide(name, turned, yaw + turn, bearing + turn, speed)
    assert after.polar.density == approx(np.roll(before.polar.density, 18 * quarters), abs=1e-6)
    assert tied(before) or same(before.heading, after.heading, turn)


@given(world=worlds, yaw=headings, bearing=headings, speed=speeds, sectors=st.integers(1, 71))
@example(world=[(0, 3, 800)], yaw=0.0, bearing=0.0, speed=0.5, sectors=25)
def test_a_world_some_sectors_round_turns_the_decision_with_it(
    name: str, world: list[Cell], yaw: float, bearing: float, speed: float, sectors: int
) -> None:
    """The cells of the window are turned, as no grid can be: they then lie between the places of cells."""
    turn = sectors * tau / 72.0
    window = turned_window(sectors)
    before = decide(name, world, yaw, bearing, speed)
    local = local_grid(world)
    view = Obstacles(window).view(local, facing(yaw + turn), NOW)
    after = method(name, window).steer(view, speed, Goal(bearing + turn))
    assert after.polar.density == approx(np.roll(before.polar.density, sectors), abs=1e-6)
    assert tied(before) or same(before.heading, after.heading, turn)


def turned_window(sectors: int) -> Window:
    window, turn = copy.copy(WINDOW), sectors * tau / 72.0
    window.x = WINDOW.x * cos(turn) - WINDOW.y * sin(turn)
    window.y = WINDOW.x * sin(turn) + WINDOW.y * cos(turn)
    window.bearing = np.angle(np.exp(1j * (WINDOW.bearing + turn)))
    window.nearest_sector = (WINDOW.nearest_sector + sectors) % 72
    window.first = (WINDOW.first + sectors) % 72
    window.last = window.first + WINDOW.last - WINDOW.first
    return window


@given(world=worlds, yaw=headings, bearing=headings, speed=speeds)
def test_a_mirrored_world_mirrors_the_decision(
    name: str, world: list[Cell], yaw: float, bearing: float, speed: float
) -> None:
    """But for cells on a border between sectors, which VFH counts to the left of it."""
    world = [cell for cell in world if cell[0] and cell[1] and abs(cell[0]) != abs(cell[1])]
    mirrored = [(-row, col, milli) for row, col, milli in world]
    before = decide(name, world, yaw, bearing, speed)
    after = decide(name, mirrored, -yaw, -bearing, speed)
    assert tied(before) or same(None if before.heading is None else -before.heading, after.heading)


@given(
    world=st.lists(cells, max_size=40),
    x=within_cell,
    y=within_cell,
    yaw=finite,
    speed=finite,
    bearing=finite,
    distance=st.floats(0.0, allow_nan=False),
    unknown=st.sampled_from(Unknown),
    seen_ns=st.sampled_from([0, 1, NOW, 2 * NOW]),
)
def test_no_finite_input_gives_a_number_that_is_none(
    name: str,
    world: list[Cell],
    x: float,
    y: float,
    yaw: float,
    speed: float,
    bearing: float,
    distance: float,
    unknown: Unknown,
    seen_ns: int,
) -> None:
    view = Obstacles(WINDOW, Belief(unknown)).view(local_grid(world, seen_ns), facing(yaw, x, y), NOW)
    decision = method(name).steer(view, speed, Goal(bearing, distance))
    assert decision.heading is None or isfinite(decision.heading)
    assert 0.0 <= decision.factor <= 1.0
    assert np.all(np.isfinite(decision.polar.density))
    assert all(isfinite(candidate.cost) for candidate in decision.candidates)


@given(world=worlds, yaw=headings, bearing=headings)
def test_with_something_within_the_robot_there_is_no_way(
    name: str, world: list[Cell], yaw: float, bearing: float
) -> None:
    for inside in ((0, 0, 2000), (1, 1, 2000), (0, -1, 2000)):
        decision = decide(name, [*world, inside], yaw, bearing)
        assert (decision.heading, decision.factor, decision.why) == (None, 0.0, Why.TOUCHING)


def test_where_nothing_is_known_no_way_is_open_if_the_unknown_is_blocked(name: str) -> None:
    local = local_grid([], seen_ns=0)
    for unknown, heading, factor in (
        (Unknown.BLOCKED, None, 0.0),
        (Unknown.SLOW, 1.0, 0.0),
        (Unknown.CLEAR, 1.0, 1.0),
    ):
        view = Obstacles(WINDOW, Belief(unknown)).view(local, MIDDLE, NOW)
        decision = method(name).steer(view, 0.2, Goal(1.0))
        assert (decision.heading, decision.factor) == (heading, factor)


@given(world=worlds, yaw=headings, bearing=headings, speed=speeds)
def test_what_was_decided_before_it_forgot_does_not_matter(
    name: str, world: list[Cell], yaw: float, bearing: float, speed: float
) -> None:
    steering, view = method(name), view_of(world, facing(yaw))
    steering.steer(view_of([(0, 5, 2000)], facing(1.0)), 0.5, ahead(Pose(yaw=1.0)))
    steering.forget()
    assert same(
        steering.steer(view, speed, Goal(bearing)).heading, decide(name, world, yaw, bearing, speed).heading
    )
