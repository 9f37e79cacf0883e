"""Rounds of robots that steer: what their wheels do must be what takes them along."""

from math import cos, hypot, pi, sin, tan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.emulation.circuit import Circuit
from echogrid.emulation.motion import Tour
from echogrid.emulation.offices import office, office_circuit, office_tour
from echogrid.emulation.round import Round

OFFICE = office_circuit()
TRIANGLE = Circuit(((0.0, 0.0), (4.0, 0.0), (1.0, 3.0)), 0.4, pause=0.5)
TOUR = Tour(((0.0, 0.0), (2.0, 0.0), (2.0, -1.0), (0.0, 1.0)), frozenset({2}), pause=0.8)
rounds = st.sampled_from([OFFICE, TRIANGLE, TOUR, office_tour(pause=1.0)])
wheelbases = st.floats(0.1, 1.5)


@given(rounds, st.floats(0.0, 2.5), st.floats(0.0, 0.1))
def test_pose_and_yaw_are_continuous_within_the_limits(way: Round, laps: float, step: float) -> None:
    t_s = laps * way.lap_time
    (x0, y0, yaw0), (x1, y1, yaw1) = way.pose(t_s), way.pose(t_s + step)
    assert hypot(x1 - x0, y1 - y0) <= 0.4 * step + 1e-9
    assert abs(yaw1 - yaw0) <= pi / 3.0 * step + 1e-9


@given(rounds, st.floats(0.0, 2.0))
def test_the_twist_is_the_slope_of_way_and_yaw(way: Round, laps: float) -> None:
    t_s, step = laps * way.lap_time, 1e-5
    speed, rate = way.twist(t_s + 0.5 * step)
    assert (way.distance(t_s + step) - way.distance(t_s)) / step == pytest.approx(speed, abs=1e-4)
    assert (way.pose(t_s + step)[2] - way.pose(t_s)[2]) / step == pytest.approx(rate, abs=1e-4)


@given(rounds, st.floats(0.0, 2.0), wheelbases)
def test_the_steered_wheel_stands_and_rolls_as_the_floor_under_it_moves(
    way: Round, laps: float, wheelbase: float
) -> None:
    t_s, step = laps * way.lap_time, 1e-4
    if way.twist(t_s) == (0.0, 0.0) or way.twist(t_s + step) == (0.0, 0.0):
        return

    def front(at_s: float) -> tuple[float, float]:
        x, y, yaw = way.pose(at_s)
        return x + wheelbase * cos(yaw), y + wheelbase * sin(yaw)

    (x0, y0), (x1, y1) = front(t_s), front(t_s + step)
    heading = way.pose(t_s + 0.5 * step)[2] + way.steering(t_s + 0.5 * step, wheelbase)
    rolled = way.rolled(t_s + step, wheelbase) - way.rolled(t_s, wheelbase)
    assert (x1 - x0, y1 - y0) == pytest.approx((rolled * cos(heading), rolled * sin(heading)), abs=1e-6)


@given(rounds, st.floats(0.0, 2.0), wheelbases)
def test_it_is_steered_at_a_finite_rate_and_only_while_it_stands(
    way: Round, laps: float, wheelbase: float
) -> None:
    t_s, step = laps * way.lap_time, 1e-3
    turned = abs(way.steering(t_s + step, wheelbase) - way.steering(t_s, wheelbase))
    assert turned <= pi / way.pause * step + 1e-9
    if turned > 1e-9:
        assert abs(way.rolled(t_s + step, wheelbase) - way.rolled(t_s, wheelbase)) <= 1e-5


@pytest.mark.parametrize("way", [OFFICE, TRIANGLE])
def test_a_circuit_s_steering_is_that_of_its_arcs_or_straight_ahead(way: Circuit) -> None:
    seen = {
        round(tan(way.steering(float(t_s), 0.3)), 9)
        for t_s in np.arange(0.0, way.lap_time, 0.05)
        if way.twist(float(t_s))[0] > 0.0
    }
    arc = round(0.3 / way.radius, 9)
    assert seen <= {0.0, arc, -arc}
    assert {0.0, arc} <= seen


@pytest.mark.parametrize("way", [OFFICE, TRIANGLE, TOUR])
def test_every_lap_is_the_same(way: Round) -> None:
    x, y, yaw = way.pose(3.0)
    assert way.pose(3.0 + 2.0 * way.lap_time) == pytest.approx((x, y, yaw + 2.0 * way.lap_turn), abs=1e-9)
    assert way.lap_turn / (2.0 * pi) == pytest.approx(round(way.lap_turn / (2.0 * pi)))
    lap = way.rolled(way.lap_time + 3.0, 0.3) - way.rolled(3.0, 0.3)
    assert way.rolled(2.0 * way.lap_time + 3.0, 0.3) == pytest.approx(2.0 * lap + way.rolled(3.0, 0.3))


def test_a_circuit_is_as_long_as_its_lines_and_arcs() -> None:
    around = Circuit(((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)), 0.5)
    assert around.lap_length == pytest.approx(14.0 - 8 * 0.5 + pi)
    assert around.pose(0.0) == pytest.approx((0.5, 0.0, 0.0))


def test_corners_too_close_for_their_arcs_are_refused() -> None:
    with pytest.raises(ValueError, match=r"too close for arcs of 1\.1 m"):
        Circuit(((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)), 1.1)


def test_the_office_circuit_keeps_clear_of_everything() -> None:
    path = np.array([OFFICE.pose(float(t_s))[:2] for t_s in np.arange(0.0, OFFICE.lap_time, 0.05)])
    assert OFFICE.lap_length > 25.0
    assert office().surface_distance(path).min() >= 0.25 + 0.10
