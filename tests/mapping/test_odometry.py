from math import cos, degrees, hypot, pi, sin, sqrt, tau

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.odometry import DifferentialDrive, arc_step, midpoint_step, propagate
from echogrid.mapping.pose import Pose, wrap_angle

from .strategies import poses

LEFT, RIGHT, TRACK, SPREAD = 0.50, 0.52, 0.4, 1e-4

ways = st.floats(-1.0, 1.0)
tracks = st.floats(0.1, 1.0)


def numbers(pose: Pose) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.yaw


@given(poses(), ways, ways, tracks)
def test_driving_an_arc_back_leads_back(start: Pose, left: float, right: float, track: float) -> None:
    end = arc_step(arc_step(start, left, right, track), -left, -right, track)
    assert (end.x, end.y) == approx((start.x, start.y), abs=1e-9)
    assert abs(wrap_angle(end.yaw - start.yaw)) < 1e-9


@given(poses(), ways, ways, tracks, st.integers(2, 20))
def test_an_arc_may_be_cut_into_pieces(
    start: Pose, left: float, right: float, track: float, pieces: int
) -> None:
    whole, cut = arc_step(start, left, right, track), start
    for _ in range(pieces):
        cut = arc_step(cut, left / pieces, right / pieces, track)
    assert (cut.x, cut.y) == approx((whole.x, whole.y), abs=1e-8)
    assert abs(wrap_angle(cut.yaw - whole.yaw)) < 1e-9


@given(poses(), ways, st.floats(-3e-6, 3e-6))
def test_nearly_straight_is_nearly_straight(start: Pose, way: float, difference: float) -> None:
    end = arc_step(start, way, way + difference, 1.0)
    straight = Pose(start.x + way * cos(start.yaw), start.y + way * sin(start.yaw))
    assert (end.x, end.y) == approx((straight.x, straight.y), abs=1e-5)


@given(poses(), ways, ways, tracks)
def test_the_midpoint_rule_differs_by_the_cube_of_the_turn_at_most(
    start: Pose, left: float, right: float, track: float
) -> None:
    """Chord against arc: sin(h)/h with h half the turn."""
    arc, middle = arc_step(start, left, right, track), midpoint_step(start, left, right, track)
    turn, way = (right - left) / track, abs(left + right) / 2.0
    assert hypot(arc.x - middle.x, arc.y - middle.y) <= way * turn**2 / 24.0 + 1e-9
    assert abs(wrap_angle(arc.yaw - middle.yaw)) < 1e-9


@given(poses(), ways, ways, tracks)
def test_the_covariance_stays_symmetric_and_never_shrinks(
    pose: Pose, left: float, right: float, track: float
) -> None:
    before = np.diag([1e-4, 2e-4, 3e-4])
    after = propagate(before, pose, left, right, track, SPREAD)
    assert after == approx(after.T, abs=1e-15)
    assert np.linalg.eigvalsh(after).min() >= -1e-15
    assert np.linalg.det(after) >= np.linalg.det(before) * (1.0 - 1e-9)


@given(poses(), ways, ways, tracks)
def test_the_covariance_is_that_of_the_step_s_numeric_derivatives(
    pose: Pose, left: float, right: float, track: float
) -> None:
    def step(values: np.ndarray) -> np.ndarray:
        end = midpoint_step(Pose(*values[:3]), values[3], values[4], track)
        return np.array([end.x, end.y, pose.yaw + wrap_angle(end.yaw - pose.yaw)])

    at, slight = np.array([*numbers(pose), left, right]), 1e-6
    slopes = np.array([(step(at + d) - step(at - d)) / (2.0 * slight) for d in np.eye(5) * slight]).T
    before = np.diag([1e-4, 2e-4, 3e-4])
    inputs = np.zeros((5, 5))
    inputs[:3, :3] = before
    inputs[3, 3], inputs[4, 4] = SPREAD * abs(left), SPREAD * abs(right)
    expected = slopes @ inputs @ slopes.T
    assert propagate(before, pose, left, right, track, SPREAD) == approx(expected, abs=1e-8, rel=1e-5)


def test_two_midpoint_steps_with_their_covariance() -> None:
    start = Pose()
    first = midpoint_step(start, LEFT, RIGHT, TRACK)
    assert numbers(first) == approx((0.5098406, 0.0127487, 0.05), abs=1e-6)
    covariance = propagate(np.zeros((3, 3)), start, LEFT, RIGHT, TRACK, SPREAD)
    assert np.diag(covariance) == approx([2.5478107e-5, 4.1475330e-5, 6.375e-4], abs=1e-11)
    assert covariance[0, 2] == approx(-1.5644204e-6, abs=1e-12)
    assert covariance[1, 2] == approx(1.62574195e-4, abs=1e-12)
    second = midpoint_step(first, LEFT, RIGHT, TRACK)
    assert numbers(second) == approx((1.0184069, 0.0509628, 0.1), abs=1e-6)
    covariance = propagate(covariance, first, LEFT, RIGHT, TRACK, SPREAD)
    x, y, yaw = (sqrt(variance) for variance in np.diag(covariance))
    assert (x, y) == approx((7.2126924e-3, 20.3267502e-3), abs=1e-9)
    assert degrees(yaw) == approx(2.0458685, abs=1e-6)


def test_the_exact_arc_of_the_first_step() -> None:
    end = arc_step(Pose(), LEFT, RIGHT, TRACK)
    assert numbers(end) == approx((0.5097875, 0.0127473, 0.05), abs=1e-6)


def test_wheels_against_each_other_turn_on_the_spot() -> None:
    quarter = pi / 2.0 * TRACK / 2.0
    assert numbers(arc_step(Pose(1.0, 2.0), -quarter, quarter, TRACK)) == approx((1.0, 2.0, pi / 2.0))


def test_where_the_wheels_first_stand_is_the_origin() -> None:
    drive = DifferentialDrive(0.06, 0.32)
    assert drive.update(123.0, -45.0) == Pose()
    assert drive.travelled == 0.0


def test_a_turn_of_both_wheels_is_their_circumference() -> None:
    drive = DifferentialDrive(0.06, 0.32)
    drive.update(1.0, 2.0)
    pose = drive.update(1.0 + tau, 2.0 + tau)
    assert numbers(pose) == approx((0.06 * tau, 0.0, 0.0))
    assert drive.travelled == approx(0.06 * tau)


@given(st.lists(st.tuples(ways, ways), max_size=20))
def test_the_drive_adds_up_the_arcs_between_the_angles(steps: list[tuple[float, float]]) -> None:
    drive, pose, travelled = DifferentialDrive(0.06, 0.32), Pose(), 0.0
    left = right = 0.0
    drive.update(left, right)
    for more_left, more_right in steps:
        left, right = left + more_left, right + more_right
        drive.update(left, right)
        pose = arc_step(pose, 0.06 * more_left, 0.06 * more_right, 0.32)
        travelled += 0.06 * abs(more_left + more_right) / 2.0
    assert numbers(drive.pose) == approx(numbers(pose), abs=1e-9)
    assert drive.travelled == approx(travelled, abs=1e-12)
