from dataclasses import replace
from math import pi, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.steering.decision import Decision
from echogrid.mapping.steering.goal import Goal
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.pace import Manner, Pace
from echogrid.mapping.twist import Twist

from .scenes import BODY, LIMITS, MIDDLE, Cell, facing, headings, method, view_of, worlds

anything = st.floats(-100.0, 100.0)
above_0 = st.floats(0.01, 10.0)
limits = st.builds(Limits, above_0, above_0, above_0, above_0)
twists = st.builds(Twist, anything, anything)
METHODS = st.sampled_from(["vff", "vfh", "vfh+"])


def decided(world: list[Cell], yaw: float, bearing: float, name: str = "vfh+") -> Decision:
    return method(name).steer(view_of(world, facing(yaw)), 0.0, Goal(bearing))


@given(limits, twists, twists, st.floats(0.0, 2.0))
def test_what_is_reached_is_within_the_limits(
    limits: Limits, wish: Twist, now: Twist, elapsed_s: float
) -> None:
    reached = limits.reach(wish, now, elapsed_s)
    assert abs(reached.speed) <= limits.speed
    assert abs(reached.turn_rate) <= limits.turn_rate


@given(limits, twists, twists, st.floats(0.0, 2.0))
def test_what_is_reached_is_near_what_was_and_no_farther_from_the_wish(
    limits: Limits, wish: Twist, before: Twist, elapsed_s: float
) -> None:
    now = limits.reach(before, before, 0.0)
    reached = limits.reach(wish, now, elapsed_s)
    assert abs(reached.speed - now.speed) <= limits.acceleration * elapsed_s + 1e-9
    assert abs(reached.turn_rate - now.turn_rate) <= limits.turn_acceleration * elapsed_s + 1e-9
    assert abs(reached.speed - wish.speed) <= abs(now.speed - wish.speed)
    assert abs(reached.turn_rate - wish.turn_rate) <= abs(now.turn_rate - wish.turn_rate)


@pytest.mark.parametrize("name", ["speed", "turn_rate", "acceleration", "turn_acceleration"])
def test_a_robot_that_cannot_move_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="above 0"):
        Limits(**{name: 0.0})


@given(limits, METHODS, worlds, headings, headings)
def test_a_wish_is_within_the_limits_and_never_backwards(
    limits: Limits, name: str, world: list[Cell], yaw: float, bearing: float
) -> None:
    wish = Pace(limits).wish(view_of(world, facing(yaw)), decided(world, yaw, bearing, name))
    assert 0.0 <= wish.speed <= limits.speed
    assert abs(wish.turn_rate) <= limits.turn_rate


@given(st.integers(3, 10), st.integers(-2, 2), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_the_robot_can_always_stop_before_it_touches(
    away: int, aside: int, yaw: float, heading: float
) -> None:
    """v t + v^2/2a is within the clearance, less the margin, of where it drives now and of where it will."""
    view = view_of([(aside, away, 2000)], facing(yaw))
    decision = replace(decided([], yaw, heading), heading=heading)
    speed = Pace(LIMITS).wish(view, decision).speed
    room = min(view.clearance(yaw), view.clearance(heading)) - BODY.margin
    needs = speed * Manner().latency_s + speed**2 / (2.0 * LIMITS.acceleration)
    assert needs <= max(room, 0.0) + 1e-9


def test_what_stands_ahead_slows_a_robot_that_is_to_turn_away_from_it() -> None:
    view, decision = view_of([(0, 3, 2000)]), decided([], 0.0, 0.8)
    assert Pace(LIMITS).wish(view, decision).speed < Pace(LIMITS).wish(view_of([]), decision).speed


def test_between_the_robot_and_what_it_stops_for_its_margin_stays() -> None:
    view, decision = view_of([(0, 3, 2000)]), decided([], 0.0, 0.0)
    assert view.clearance(0.0) == approx(BODY.margin)
    assert Pace(LIMITS).wish(view, decision).speed == approx(0.0, abs=1e-9)


@given(st.floats(0.0, 50.0), limits)
def test_the_stopping_distance_of_the_speed_is_the_room(room: float, limits: Limits) -> None:
    speed = Pace(limits).stoppable(room)
    assert speed * 0.25 + speed**2 / (2.0 * limits.acceleration) == approx(room, abs=1e-6)


def test_half_a_metre_a_second_needs_375_mm_to_stop() -> None:
    assert Pace(LIMITS).stoppable(0.375) == approx(0.5)


def test_without_a_heading_it_stands() -> None:
    decision = decided([(0, 0, 2000)], 0.0, 0.0)
    assert Pace(LIMITS).wish(view_of([]), decision) == Twist()


def test_in_the_open_it_drives_at_full_speed_towards_the_goal() -> None:
    assert Pace(LIMITS).wish(view_of([], MIDDLE), decided([], 0.0, 0.0)) == Twist(LIMITS.speed, 0.0)


@given(headings)
def test_the_more_it_must_turn_the_slower_it_drives(turn: float) -> None:
    wish = Pace(LIMITS).wish(view_of([]), decided([], 0.0, turn))
    ahead = Pace(LIMITS).wish(view_of([]), decided([], 0.0, turn * 0.9))
    assert wish.speed <= ahead.speed
    assert wish.turn_rate * turn >= 0.0


def test_it_turns_in_place_until_it_is_nearly_aligned() -> None:
    pace = Pace(LIMITS)
    moves = [
        pace.wish(view_of([]), decided([], 0.0, radians(turn))).speed > 0.0
        for turn in (50, 70, 50, 40, 30, 40, 50)
    ]
    assert moves == [True, False, False, False, True, True, True]


@given(st.floats(0.0, 3.0))
def test_it_slows_down_for_the_goal(distance: float) -> None:
    view = view_of([])
    decision = method("vfh+").steer(view, 0.0, Goal(0.0, distance))
    speed = Pace(LIMITS).wish(view, decision).speed
    assert speed * 0.25 + speed**2 / (2.0 * LIMITS.acceleration) <= distance + 1e-9


@given(headings)
def test_a_mirrored_decision_mirrors_the_twist(turn: float) -> None:
    left, right = (Pace(LIMITS).wish(view_of([]), decided([], 0.0, bearing)) for bearing in (turn, -turn))
    assert (left.speed, left.turn_rate) == approx((right.speed, -right.turn_rate)) or abs(turn) == pi
