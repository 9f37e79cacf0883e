"""The swept path against its twin: the motion sampled densely, with a test of the polygon at every step."""

from math import cos, hypot, inf, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.footprint import Footprint
from echogrid.mapping.swept_path import fastest, sweeps, touches
from echogrid.mapping.twist import Twist

from .outlines import BOX, outlines

STEPS = 12_000
TOUCH = 1e-6
speeds, rates = st.floats(-1.0, 1.0), st.floats(-2.0, 2.0)
twists = (
    st.builds(Twist, speeds, rates)
    | st.builds(Twist, speeds.filter(lambda v: abs(v) > 0.01), st.just(0.0) | st.floats(-1e-4, 1e-4))
    | st.builds(Twist, st.just(0.0), rates)
).filter(lambda twist: fastest(BOX, twist) > 0.02)
places = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
radii = st.sampled_from([0.001, 0.035, 0.2])


def touch(outline: Footprint, twist: Twist, place: tuple[float, float], radius: float) -> float:
    return float(touches(outline, twist, np.array([place[0]]), np.array([place[1]]), radius)[0])


def gaps(outline: Footprint, twist: Twist, place: tuple[float, float], times: np.ndarray) -> np.ndarray:
    """m from the outline to a point of the world, at times on the way."""
    turn = twist.turn_rate * times
    half = turn / 2.0
    chord = twist.speed * times * np.sinc(half / pi)
    dx, dy = place[0] - chord * np.cos(half), place[1] - chord * np.sin(half)
    return outline.distance(np.cos(turn) * dx + np.sin(turn) * dy, np.cos(turn) * dy - np.sin(turn) * dx)


@settings(deadline=None, max_examples=400)
@given(outlines, twists, places, radii)
def test_it_touches_when_dense_sampling_of_the_motion_says_so(
    outline: Footprint, twist: Twist, place: tuple[float, float], radius: float
) -> None:
    lasts = min(3.0 / fastest(outline, twist), 6.0 / max(abs(twist.turn_rate), 1e-9))
    times = np.linspace(0.0, lasts, STEPS)
    away = gaps(outline, twist, place, times)
    found = touch(outline, twist, place, radius)
    if away[0] <= TOUCH:
        assert found == inf
        return
    near = min(radius, away[0] - TOUCH)
    step = fastest(outline, twist) * times[1]
    sure = np.flatnonzero(away <= near - 1e-9)
    if len(sure):  # no later than the first sample at which it is touched
        assert found <= times[sure[0]] + 1e-9
    if found <= lasts:  # and it truly is then, and not before
        assert gaps(outline, twist, place, np.array([found]))[0] <= near + 1e-6
        before = away[times < found - 1e-9]
        assert before.min(initial=inf) >= near - step


@given(outlines, twists, places, radii, st.floats(0.1, 10.0))
def test_a_faster_robot_comes_to_the_same_place_earlier(
    outline: Footprint, twist: Twist, place: tuple[float, float], radius: float, factor: float
) -> None:
    found = touch(outline, twist, place, radius)
    assert touch(outline, twist.times(factor), place, radius) * factor == approx(found, rel=1e-6, abs=1e-6)


@given(outlines, twists, places, radii)
def test_the_mirrored_robot_comes_to_the_mirrored_place_at_the_same_time(
    outline: Footprint, twist: Twist, place: tuple[float, float], radius: float
) -> None:
    mirrored = Footprint([(x, -y) for x, y in outline.corners])
    found = touch(mirrored, Twist(twist.speed, -twist.turn_rate), (place[0], -place[1]), radius)
    assert found == approx(touch(outline, twist, place, radius), rel=1e-6, abs=1e-6)


@given(outlines, twists, places)
def test_a_larger_disc_is_never_touched_later(
    outline: Footprint, twist: Twist, place: tuple[float, float]
) -> None:
    small, large = (touch(outline, twist, place, radius) for radius in (0.02, 0.1))
    gap = gaps(outline, twist, place, np.zeros(1))[0]
    if gap > 0.1 + TOUCH:
        assert large <= small + 1e-9


@pytest.mark.parametrize("distance", [0.3, 1.0, 1.9])
def test_straight_ahead_it_is_the_gap_by_the_speed(distance: float) -> None:
    assert touch(BOX, Twist(0.5), (0.2 + distance, 0.1), 0.05) == approx((distance - 0.05) / 0.5)


@pytest.mark.parametrize("rate", [1.0, -1.0])
def test_a_turn_on_the_spot_ends_where_the_corner_meets_it(rate: float) -> None:
    """The corner of the box lies 0.25 m away, at 36.87 deg."""
    place = 0.249 * cos(pi / 2), 0.249 * sin(pi / 2)
    start = np.arctan2(0.15, 0.2) if rate > 0.0 else pi - np.arctan2(0.15, 0.2)
    assert touch(BOX, Twist(0.0, rate), place, 1e-3) == approx(abs(pi / 2 - start), abs=0.05)


def test_along_a_wall_that_it_all_but_touches_the_robot_may_drive_on_but_not_into_it() -> None:
    beside = np.array([0.0, 0.1, 0.15]), np.full(3, 0.16)
    assert np.all(np.isinf(touches(BOX, Twist(0.5), *beside, 0.035)))
    assert np.all(np.isinf(touches(BOX, Twist(-0.5), *beside, 0.035)))
    assert touches(BOX, Twist(0.5, 0.5), *beside, 0.035).min() < 0.05


def test_what_it_touches_from_the_front_it_may_leave_backwards() -> None:
    assert touch(BOX, Twist(0.5), (0.21, 0.0), 0.035) < 1e-4
    assert touch(BOX, Twist(-0.5), (0.21, 0.0), 0.035) == inf


@given(outlines, twists, places)
def test_it_comes_over_a_point_when_it_touches_the_smallest_disc_there(
    outline: Footprint, twist: Twist, place: tuple[float, float]
) -> None:
    point = np.array([place[0]]), np.array([place[1]])
    if outline.distance(*point)[0] > 1e-3:
        covered = float(sweeps(outline, twist, *point)[0])
        assert touch(outline, twist, place, 1e-7) <= covered + 1e-6
        if covered < inf:
            assert gaps(outline, twist, place, np.array([covered]))[0] <= 1e-6


def test_a_robot_that_stands_touches_nothing() -> None:
    assert touch(BOX, Twist(), (0.3, 0.0), 0.2) == inf


@settings(max_examples=30)
@given(st.floats(-1.0, 1.0), st.floats(0.5, 1.9), st.sampled_from([1.0, -1.0]))
def test_the_widest_arcs_join_the_straight_way(across: float, ahead: float, side: float) -> None:
    straight = touch(BOX, Twist(0.5), (ahead, across), 0.035)
    arc = touch(BOX, Twist(0.5, side * 0.5 / 0.99e5), (ahead, across), 0.035)
    assert arc == approx(straight, abs=1e-3) or abs(abs(across) - 0.185) < 1e-3


@settings(deadline=None)
@given(outlines, twists, st.lists(places, min_size=1, max_size=20), radii, st.floats(0.0, 12.0))
def test_with_an_end_all_that_comes_before_it_is_the_same_to_the_bit(
    outline: Footprint, twist: Twist, ways: list[tuple[float, float]], radius: float, within: float
) -> None:
    x, y = np.array(ways).T
    outside = outline.distance(x, y) > TOUCH
    for whole, ended in (
        (touches(outline, twist, x, y, radius), touches(outline, twist, x, y, radius, within)),
        (sweeps(outline, twist, x, y)[outside], sweeps(outline, twist, x, y, within)[outside]),
    ):
        soon = whole <= within
        assert np.array_equal(ended[soon], whole[soon])
        assert np.all((ended[~soon] == whole[~soon]) | (ended[~soon] == inf))


@given(outlines, speeds, rates)
def test_the_fastest_corner_is_the_fastest_of_all(outline: Footprint, speed: float, rate: float) -> None:
    each = [hypot(speed - rate * y, rate * x) for x, y in outline.corners]
    assert fastest(outline, Twist(speed, rate)) == max(each)
