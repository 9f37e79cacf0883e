from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from echogrid.emulation.motion import Limits, Tour
from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.stroke import Stroke

TOUR = office_tour()
SQUARE = Tour(((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)), spins=frozenset({2}))
times = st.floats(0.0, 2.5 * TOUR.lap_time)


@given(times, st.floats(0.0, 0.1))
def test_the_pose_is_continuous_and_within_the_limits(t_s, step):
    x0, y0, yaw0 = TOUR.pose(t_s)
    x1, y1, yaw1 = TOUR.pose(t_s + step)
    assert np.hypot(x1 - x0, y1 - y0) <= TOUR.limits.speed * step + 1e-9
    assert abs(yaw1 - yaw0) <= TOUR.limits.turn_rate * step + 1e-9


@given(times)
def test_the_twist_is_the_slope_of_distance_and_yaw(t_s):
    step = 1e-5
    speed, rate = TOUR.twist(t_s + 0.5 * step)
    assert (TOUR.distance(t_s + step) - TOUR.distance(t_s)) / step == pytest.approx(speed, abs=1e-4)
    assert (TOUR.pose(t_s + step)[2] - TOUR.pose(t_s)[2]) / step == pytest.approx(rate, abs=1e-4)


@settings(deadline=None, max_examples=10)
@given(st.floats(0.01, 0.2), st.floats(0.1, 0.6))
def test_integrating_the_wheels_gives_the_pose(wheel_radius, track):
    x, y, yaw = SQUARE.pose(0.0)
    instants = np.linspace(0.0, 1.7 * SQUARE.lap_time, 4000)
    angles = np.array([SQUARE.wheel_angles(t_s, wheel_radius, track) for t_s in instants])
    assert angles[0] == pytest.approx([0.0, 0.0])
    for left, right in np.diff(angles, axis=0) * wheel_radius:
        turn = (right - left) / track
        x += 0.5 * (left + right) * cos(yaw + 0.5 * turn)
        y += 0.5 * (left + right) * sin(yaw + 0.5 * turn)
        yaw += turn
    assert (x, y, yaw) == pytest.approx(SQUARE.pose(instants[-1]), abs=2e-3)


@given(st.floats(0.0, TOUR.lap_time, exclude_max=True), st.integers(1, 50))
def test_every_lap_is_the_same(t_s, laps):
    x, y, yaw = TOUR.pose(t_s)
    later = TOUR.pose(t_s + laps * TOUR.lap_time)
    assert later == pytest.approx((x, y, yaw + laps * TOUR.lap_turn), abs=1e-6)
    gone = TOUR.distance(t_s) + laps * TOUR.lap_length
    assert TOUR.distance(t_s + laps * TOUR.lap_time) == pytest.approx(gone, abs=1e-6)


def test_a_lap_turns_the_robot_by_full_turns():
    turns = TOUR.lap_turn / (2.0 * pi)
    assert turns == pytest.approx(round(turns), abs=1e-9)
    assert SQUARE.lap_turn == pytest.approx(4.0 * pi)


def test_it_passes_every_way_point():
    path = np.array([SQUARE.pose(t_s)[:2] for t_s in np.arange(0.0, SQUARE.lap_time, 0.01)])
    for point in SQUARE.waypoints:
        assert np.hypot(*(path - point).T).min() < 1e-3


def test_it_stands_before_the_start_and_at_each_way_point():
    assert TOUR.pose(-5.0) == TOUR.pose(0.0)
    assert TOUR.twist(0.0) == (0.0, 0.0)
    assert SQUARE.pose(SQUARE.lap_time)[:2] == pytest.approx(SQUARE.pose(0.0)[:2], abs=1e-9)


@given(st.floats(0.0, 100.0))
def test_a_robot_that_waits_drives_the_same_tour_later(t_s):
    waiting = Tour(SQUARE.waypoints, SQUARE.spins, wait=3.0)
    assert waiting.pose(t_s + 3.0) == pytest.approx(SQUARE.pose(t_s), abs=1e-9)
    assert waiting.pose(min(t_s, 3.0)) == SQUARE.pose(0.0)


@given(st.floats(-9.0, 9.0), st.floats(0.05, 2.0), st.floats(0.1, 3.0))
def test_a_stroke_goes_its_way_within_its_limits(way, top_speed, acceleration):
    assume(abs(way) > 1e-3)
    stroke = Stroke.of(way, top_speed, acceleration)
    assert stroke.at(0.0) == pytest.approx((0.0, 0.0))
    assert stroke.at(stroke.duration) == pytest.approx((way, 0.0), abs=1e-9)
    halfway, speed = stroke.at(0.5 * stroke.duration)
    assert halfway == pytest.approx(0.5 * way)
    assert abs(speed) <= top_speed + 1e-9


def test_a_longer_way_at_the_same_limits_takes_longer():
    slow = Tour(SQUARE.waypoints, limits=Limits(speed=0.2))
    assert slow.lap_time > Tour(SQUARE.waypoints).lap_time
    assert slow.lap_length == pytest.approx(6.0)


def test_the_office_tour_is_long_and_keeps_clear_of_everything():
    path = np.array([TOUR.pose(t_s)[:2] for t_s in np.arange(0.0, TOUR.lap_time, 0.05)])
    assert TOUR.lap_length >= 60.0
    assert office().surface_distance(path).min() >= 0.25 + 0.10
