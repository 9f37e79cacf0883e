from collections.abc import Callable
from math import cos, pi, sin, tan

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.kinematics import Ackermann, Differential, Motion, Tricycle, skid_steer
from echogrid.mapping.odometry import arc_step
from echogrid.mapping.pose import Pose

STEERED = (0.1, 0.8, 1e-4, 1e-3)
"""Radius, wheelbase (m), spreads of way and steering."""

ways = st.floats(-5.0, 5.0)
long_ways = ways.filter(lambda angle: abs(angle) > 0.05)
steerings = st.floats(-1.2, 1.2)
tracks = st.floats(0.1, 1.0)
radii = st.floats(0.02, 0.3)


def covariance(motion: Motion) -> np.ndarray:
    return np.array([[motion.forward_variance, motion.shared], [motion.shared, motion.turn_variance]])


def carried(motion_of: Callable[[np.ndarray], Motion], at: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """J Q J' with the numeric Jacobian of forward and turn."""
    slight = 1e-6

    def values(inputs: np.ndarray) -> np.ndarray:
        motion = motion_of(inputs)
        return np.array([motion.forward, motion.turn])

    slopes = [(values(at + d) - values(at - d)) / (2.0 * slight) for d in np.eye(len(at)) * slight]
    jacobian = np.array(slopes).T
    result: np.ndarray = jacobian @ np.diag(noise) @ jacobian.T
    return result


@given(ways, ways, radii, radii, tracks)
def test_a_differential_drive_s_doubt_is_its_wheels(
    left: float, right: float, left_radius: float, right_radius: float, track: float
) -> None:
    drive = Differential(left_radius, right_radius, track, 1e-4)
    start = (0.0, 0.0)
    rolled = np.array([left * left_radius, right * right_radius])
    plain = Differential(1.0, 1.0, track, 0.0)
    expected = carried(lambda at: plain.motion(start, (at[0], at[1])), rolled, 1e-4 * abs(rolled))
    assert covariance(drive.motion(start, (left, right))) == approx(expected, rel=1e-6, abs=1e-10)


@given(long_ways, steerings)
def test_a_tricycle_s_doubt_is_its_way_s_and_its_steering_s(angle: float, steering: float) -> None:
    assert_steered_doubt(Tricycle(*STEERED), angle, steering)


@given(long_ways, steerings)
def test_an_ackermann_drive_s_doubt_is_its_way_s_and_its_steering_s(angle: float, steering: float) -> None:
    assert_steered_doubt(Ackermann(*STEERED), angle, steering)


def assert_steered_doubt(drive: Tricycle | Ackermann, angle: float, steering: float) -> None:
    way = 0.1 * angle
    noise = np.array([1e-4 * abs(way) / 0.1**2, 1e-3 / abs(way)])
    expected = carried(
        lambda at: drive.motion((0.0, at[1]), (at[0], at[1])), np.array([angle, steering]), noise
    )
    found = covariance(drive.motion((0.0, steering), (angle, steering)))
    assert found == approx(expected, rel=1e-5, abs=1e-9)
    assert np.linalg.eigvalsh(found).min() >= -1e-15


@given(ways, steerings, st.sampled_from([Tricycle(*STEERED), Ackermann(*STEERED)]), st.integers(2, 9))
def test_into_how_many_steps_a_way_is_cut_does_not_matter(
    angle: float, steering: float, drive: Tricycle | Ackermann, pieces: int
) -> None:
    whole = drive.motion((0.0, steering), (angle, steering))
    one = drive.motion((0.0, steering), (angle / pieces, steering))
    assert (pieces * one.forward, pieces * one.turn) == approx((whole.forward, whole.turn), abs=1e-12)
    assert pieces * covariance(one) == approx(covariance(whole), abs=1e-12)


@given(st.floats(0.1, 5.0), st.floats(0.05, 1.2))
def test_a_tricycle_drives_around_the_point_where_its_axles_meet(angle: float, steering: float) -> None:
    motion = Tricycle(*STEERED).motion((0.0, steering), (angle, steering))
    assert motion.forward / motion.turn == approx(0.8 / tan(steering))


@given(st.floats(0.1, 5.0), st.floats(0.05, 1.2))
def test_so_does_an_ackermann_drive(angle: float, steering: float) -> None:
    motion = Ackermann(*STEERED).motion((0.0, steering), (angle, steering))
    assert motion.forward / motion.turn == approx(0.8 / tan(steering))


@given(ways, st.sampled_from([Tricycle(*STEERED), Ackermann(*STEERED)]))
def test_steered_straight_ahead_they_go_straight_ahead(angle: float, drive: Tricycle | Ackermann) -> None:
    motion = drive.motion((0.0, 0.0), (angle, 0.0))
    assert (motion.forward, motion.turn) == (approx(0.1 * angle), 0.0)


def test_a_tricycle_steered_across_turns_on_the_spot() -> None:
    motion = Tricycle(*STEERED).motion((0.0, pi / 2.0), (4.0, pi / 2.0))
    assert (motion.forward, motion.turn) == approx((0.0, 0.5))


def test_the_steering_of_a_step_is_the_mean_of_its_ends() -> None:
    moving, still = (Tricycle(*STEERED).motion((0.0, first), (1.0, 0.4)) for first in (0.2, 0.4))
    assert (moving.forward, moving.turn) == approx((0.1 * cos(0.3), 0.1 * sin(0.3) / 0.8))
    assert still.forward == approx(0.1 * cos(0.4))


def test_a_skid_steered_robot_turns_less_for_the_same_ways() -> None:
    rolling = Differential(0.1, 0.1, 0.4, 1e-4)
    skidding = skid_steer(rolling, 1.6)
    ways_of_wheels = (0.0, 0.0), (-2.0, 3.0)
    assert skidding.motion(*ways_of_wheels).turn == approx(rolling.motion(*ways_of_wheels).turn / 1.6)
    assert skidding.motion(*ways_of_wheels).forward == rolling.motion(*ways_of_wheels).forward


def test_a_larger_right_wheel_bends_the_way_to_the_left() -> None:
    motion = Differential(0.1, 0.102, 0.4, 1e-4).motion((0.0, 0.0), (10.0, 10.0))
    assert motion.turn == approx(0.02 / 0.4)
    assert arc_step(Pose(), motion).y > 0.0


def test_the_worked_motion() -> None:
    motion = Differential(1.0, 1.0, 0.4, 1e-4).motion((0.0, 0.0), (0.50, 0.52))
    assert (motion.forward, motion.turn) == approx((0.51, 0.05))
    assert (motion.forward_variance, motion.turn_variance) == approx((2.55e-5, 6.375e-4))
    assert motion.shared == approx(2.5e-6)


@given(st.floats(-2.0, 2.0), st.floats(-3.0, 3.0))
def test_a_twist_s_wheel_rates_make_that_twist(speed: float, turn_rate: float) -> None:
    drive = Differential(0.1, 0.11, 0.4, 0.0)
    motion = drive.motion((0.0, 0.0), drive.rates(speed, turn_rate))
    assert (motion.forward, motion.turn) == approx((speed, turn_rate), abs=1e-12)
