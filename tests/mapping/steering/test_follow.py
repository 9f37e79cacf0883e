"""Along a way as far as the robot fits straight; by VFH+ where there is none."""

from dataclasses import replace
from math import atan2, cos, hypot, inf, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.pose import Pose
from echogrid.mapping.steering.decision import Decision, Why
from echogrid.mapping.steering.follow import Follow
from echogrid.mapping.steering.goal import Goal, Point
from echogrid.mapping.steering.vfh_plus import VfhPlus

from .by_hand import obstacles
from .scenes import (
    BODY,
    LIMITS,
    MIDDLE,
    RESOLUTION,
    WINDOW,
    Cell,
    facing,
    headings,
    speeds,
    view_of,
    within_cell,
    worlds,
)

DISC = RESOLUTION / sqrt(2.0)
"""m: of an obstacle's cell."""
spots = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
ways = st.lists(spots, min_size=1, max_size=8).map(tuple)
goals = st.builds(Goal, headings, st.floats(0.2, 9.0))


def same(one: Decision, other: Decision) -> bool:
    """Whether all of it is, histograms too."""
    return (
        (one.heading, one.factor, one.why, one.goal, one.candidates)
        == (other.heading, other.factor, other.why, other.goal, other.candidates)
        and np.array_equal(one.polar.density, other.polar.density)
        and np.array_equal(one.polar.blocked, other.polar.blocked)
        and np.array_equal(one.polar.masked, other.polar.masked)
    )


def between(robot: Pose, point: Point, place: Point) -> float | None:
    """m from a place to the straight way to the point; None if it is not ahead."""
    dx, dy, length = point[0] - robot.x, point[1] - robot.y, hypot(point[0] - robot.x, point[1] - robot.y)
    along = ((place[0] - robot.x) * dx + (place[1] - robot.y) * dy) / length
    across = ((place[1] - robot.y) * dx - (place[0] - robot.x) * dy) / length
    return hypot(max(along - length, 0.0), across) if along > 1e-9 else None


@given(st.lists(st.tuples(worlds, goals, speeds, headings), min_size=1, max_size=5), st.integers(0, 5))
def test_without_a_way_it_is_vfh_plus(
    moments: list[tuple[list[Cell], Goal, float, float]], forgotten: int
) -> None:
    follow, plain = Follow(WINDOW, LIMITS), VfhPlus(WINDOW, LIMITS)
    for number, (world, goal, speed, yaw) in enumerate(moments):
        if number == forgotten:
            follow.forget()
            plain.forget()
        view = view_of(world, facing(yaw))
        assert same(follow.steer(view, speed, goal), plain.steer(view, speed, goal))


@given(worlds, headings, within_cell, within_cell, ways, speeds)
def test_it_never_heads_along_the_way_through_what_it_does_not_fit_beside(
    world: list[Cell], yaw: float, x: float, y: float, way: tuple[Point, ...], speed: float
) -> None:
    robot = facing(yaw, x, y)
    decision = Follow(WINDOW, LIMITS).steer(view_of(world, robot), speed, Goal(0.0, 9.0, way, 1.0))
    plain = VfhPlus(WINDOW, LIMITS).steer(view_of(world, robot), speed, Goal(0.0, 1.0))
    if (decision.heading, decision.why) == (plain.heading, plain.why):
        return
    assert decision.why is Why.TARGET
    headed = [p for p in way if atan2(p[1] - robot.y, p[0] - robot.x) == approx(decision.heading, abs=1e-9)]
    assert any(
        all(
            away is None or away >= BODY.radius + DISC - 1e-9
            for row, col, _ in obstacles(world)
            for away in [between(robot, p, (MIDDLE.x + col * RESOLUTION, MIDDLE.y + row * RESOLUTION))]
        )
        for p in headed
    )


@given(headings, st.lists(st.floats(0.05, 1.5), min_size=1, max_size=8), headings)
def test_where_nothing_stands_it_heads_for_the_end_of_the_way(
    bearing: float, away: list[float], yaw: float
) -> None:
    robot = facing(yaw)
    way = tuple((robot.x + far * cos(bearing), robot.y + far * sin(bearing)) for far in sorted(away))
    goal = Goal(bearing, 5.0, way, away[-1])
    decision = Follow(WINDOW, LIMITS).steer(view_of([], robot), 0.3, goal)
    assert (decision.why, decision.factor, decision.goal) == (Why.TARGET, 1.0, goal)
    assert cos(decision.heading - bearing) == approx(1.0)


@given(worlds, goals, ways)
def test_the_goal_that_is_told_is_the_one_that_was_given(
    world: list[Cell], goal: Goal, way: tuple[Point, ...]
) -> None:
    goal = replace(goal, way=way, near=1.0)
    assert Follow(WINDOW, LIMITS).steer(view_of(world), 0.3, goal).goal == goal


@given(ways)
def test_while_something_touches_the_robot_the_way_is_not_gone(way: tuple[Point, ...]) -> None:
    view = view_of([(0, 1, 2000)], facing(0.0, 0.0, 0.0))
    decision = Follow(WINDOW, LIMITS).steer(view, 0.0, Goal(pi, 5.0, way, 1.0))
    assert view.touching
    assert (decision.heading, decision.why) == (None, Why.TOUCHING)


def test_round_a_corner_it_heads_for_the_last_point_it_fits_to() -> None:
    """Obstacles 0.4 m beside the first leg, which ends 1 m ahead: the corner hides the second leg."""
    way = tuple((MIDDLE.x + 0.25 * n, MIDDLE.y) for n in range(1, 5))
    way += tuple((MIDDLE.x + 1.0, MIDDLE.y + 0.25 * n) for n in range(1, 5))
    world = [(4, col, 2000) for col in range(-2, 7)]
    decision = Follow(WINDOW, LIMITS).steer(view_of(world), 0.3, Goal(0.0, 2.0, way, 1.0))
    # To (1, 0) with the whole margin, 0.2 + 0.1 + 0.071 m beside the row; to (1, 0.25) it would be 0.24 m.
    assert decision.heading == approx(0.0)


def gap(half: int) -> list[Cell]:
    """Two rows of obstacles, so many cells to either side."""
    return [(side * half, col, 2000) for side in (-1, 1) for col in range(3, 12)]


@pytest.mark.parametrize(
    ("half", "straight"),
    [(4, True), (3, True), (2, False)],
    ids=["with its margin", "with a centimetre", "not at all"],
)
def test_where_it_is_too_narrow_for_the_margin_it_goes_on_as_long_as_it_fits(
    half: int, straight: bool
) -> None:
    """0.4 m: more than 0.371; 0.3 m: more than 0.281; 0.2 m: less than 0.271."""
    way = ((MIDDLE.x + 1.2, MIDDLE.y),)
    decision = Follow(WINDOW, LIMITS).steer(view_of(gap(half)), 0.3, Goal(0.0, 1.2, way, 1.2))
    assert (decision.why is Why.TARGET and decision.heading == 0.0) == straight


def test_what_is_behind_the_robot_does_not_keep_it_from_leaving() -> None:
    way = ((MIDDLE.x + 1.0, MIDDLE.y),)
    decision = Follow(WINDOW, LIMITS).steer(view_of([(0, -3, 2000)]), 0.0, Goal(0.0, 3.0, way, 1.0))
    assert (decision.heading, decision.why) == (0.0, Why.TARGET)


def test_points_within_reach_say_nothing_as_long_as_there_are_farther_ones() -> None:
    way = ((MIDDLE.x, MIDDLE.y + 0.1), (MIDDLE.x + 1.0, MIDDLE.y))
    blocked = [(row, 8, 2000) for row in range(-2, 3)]
    decision = Follow(WINDOW, LIMITS).steer(view_of(blocked), 0.3, Goal(0.0, 5.0, way, inf))
    # Only as the last resort, with nothing kept beside the robot, is a point 0.1 m away headed for.
    assert decision.heading == approx(pi / 2.0)
