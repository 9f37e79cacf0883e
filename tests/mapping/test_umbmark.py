"""A robot with wrong wheels drives squares; what its odometry says is always the start."""

from math import degrees, hypot, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.kinematics import Differential
from echogrid.mapping.odometry import arc_step
from echogrid.mapping.pose import Pose
from echogrid.mapping.umbmark import Corrections, corrections, worst_error

SIDE, TRACK = 4.0, 0.5
CLOCKWISE, COUNTERCLOCKWISE = -1.0, 1.0
UNCORRECTED = Corrections(0.0, 0.0, 1.0, 1.0)
TRUE = Corrections(0.0, 0.0, 1.003, 0.99)
"""What is wrong with the robot."""


def square(turn: float, true: Corrections, assumed: Corrections = UNCORRECTED) -> tuple[float, float]:
    """Where the square ends: each wheel rolls its true part of what the odometry takes it to have rolled."""
    drive = Differential(true.left / assumed.left, true.right / assumed.right, TRACK * true.track_factor, 0.0)
    corner = turn * pi / 2.0 * TRACK * assumed.track_factor / 2.0
    pose = Pose()
    for _ in range(4):
        for angles in ((SIDE, SIDE), (-corner, corner)):
            pose = arc_step(pose, drive.motion((0.0, 0.0), angles))
    return pose.x, pose.y


def measured(true: Corrections) -> Corrections:
    return corrections(square(CLOCKWISE, true)[0], square(COUNTERCLOCKWISE, true)[0], SIDE, TRACK)


def worst(true: Corrections, assumed: Corrections) -> float:
    return worst_error(square(CLOCKWISE, true, assumed), square(COUNTERCLOCKWISE, true, assumed))


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_the_two_wheels_corrections_leave_the_mean_wheel_alone(clockwise: float, counter: float) -> None:
    found = corrections(clockwise, counter, SIDE, TRACK)
    assert found.left + found.right == approx(2.0)
    assert found.right / found.left == approx(found.diameter_ratio)


@given(st.floats(0.995, 1.005), st.floats(0.98, 1.02))
def test_a_corrected_robot_drives_at_least_as_good_a_square(ratio: float, track_factor: float) -> None:
    true = Corrections(0.0, 0.0, ratio, track_factor)
    assert worst(true, measured(true)) <= worst(true, UNCORRECTED) / 5.0 + 1e-3


@given(st.floats(0.995, 1.005), st.floats(0.98, 1.02))
def test_what_is_found_is_near_the_truth(ratio: float, track_factor: float) -> None:
    found = measured(Corrections(0.0, 0.0, ratio, track_factor))
    assert found.diameter_ratio == approx(ratio, abs=1e-3)
    assert found.track_factor == approx(track_factor, abs=4e-3)


def test_a_right_robot_needs_no_correction() -> None:
    found = measured(UNCORRECTED)
    assert (found.left, found.right, found.track_factor) == approx((1.0, 1.0, 1.0), abs=1e-9)


def test_errors_that_are_the_same_in_both_directions_leave_the_wheels_alone() -> None:
    assert corrections(0.1, 0.1, SIDE, TRACK).diameter_ratio == 1.0


@pytest.mark.parametrize(
    ("turn", "end"),
    [(CLOCKWISE, (-0.0653096, -0.0686191)), (COUNTERCLOCKWISE, (0.3358982, -0.2905241))],
)
def test_the_ends_of_the_squares(turn: float, end: tuple[float, float]) -> None:
    assert square(turn, TRUE) == approx(end, abs=1e-6)


def test_the_worst_error_is_that_of_the_worse_direction() -> None:
    assert worst(TRUE, UNCORRECTED) == approx(0.4441080, abs=1e-6)
    assert worst_error((3.0, 4.0), (1.0, 0.0)) == 5.0


def test_the_corrections_of_that_robot() -> None:
    found = measured(TRUE)
    assert degrees(found.alpha) == approx(-0.9689740, abs=1e-6)
    assert degrees(found.beta) == approx(1.4367198, abs=1e-6)
    assert SIDE / 2.0 / sin(found.beta / 2.0) == approx(159.52249, abs=1e-4)
    assert found.diameter_ratio == approx(1.0031393, abs=1e-6)
    assert found.track_factor == approx(0.9893483, abs=1e-6)


def test_the_corrections_from_the_printed_ends() -> None:
    found = corrections(-0.06530964, 0.33589822, SIDE, TRACK)
    assert found.diameter_ratio == approx(1.0031393, abs=1e-6)
    assert found.track_factor == approx(0.9893483, abs=1e-6)


def test_what_remains_of_the_error_after_the_correction() -> None:
    found = measured(TRUE)
    remaining = [hypot(*square(turn, TRUE, found)) for turn in (CLOCKWISE, COUNTERCLOCKWISE)]
    assert remaining == approx([0.0009973, 0.0244169], abs=1e-6)
    assert worst(TRUE, UNCORRECTED) / worst(TRUE, found) > 18.0
