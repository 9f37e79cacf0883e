from math import cos, degrees, hypot, pi, sin, sqrt, tau

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.gyro import Gyro
from echogrid.mapping.kinematics import Differential, Motion
from echogrid.mapping.odometry import Odometry, arc_step, midpoint_step, propagate
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.yaw_fusion import YawFusion

from .strategies import poses

LEFT, RIGHT, TRACK, SPREAD = 0.50, 0.52, 0.4, 1e-4
STEP = Differential(1.0, 1.0, TRACK, SPREAD).motion((0.0, 0.0), (LEFT, RIGHT))
MS = 1_000_000

motions = st.builds(Motion, st.floats(-1.0, 1.0), st.floats(-2.0, 2.0))
noisy = st.builds(
    lambda motion, left, right: Motion(
        motion.forward, motion.turn, left + right, 4 * (left + right), left - right
    ),
    motions,
    st.floats(0.0, 1e-3),
    st.floats(0.0, 1e-3),
)
steps = st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)), max_size=20)


def numbers(pose: Pose) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.yaw


def odometry() -> Odometry:
    return Odometry(Differential(0.06, 0.06, 0.32, SPREAD))


def straight(interval_ms: list[int], restarted_at: int = -1) -> Odometry:
    """0.6 m in steps of 10 rad at these intervals; one of them may follow a restart, with zero motion."""
    drive, stamp_ns, angle = odometry(), 0, 0.0
    drive.update(0, (0.0, 0.0))
    for number, interval in enumerate(interval_ms):
        stamp_ns += interval * MS
        angle += 0.0 if number == restarted_at else 10.0
        drive.update(stamp_ns, (angle, angle), number == restarted_at)
    return drive


@given(poses(), motions)
def test_driving_an_arc_back_leads_back(start: Pose, motion: Motion) -> None:
    end = arc_step(arc_step(start, motion), Motion(-motion.forward, -motion.turn))
    assert (end.x, end.y) == approx((start.x, start.y), abs=1e-9)
    assert abs(wrap_angle(end.yaw - start.yaw)) < 1e-9


@given(poses(), motions, st.integers(2, 20))
def test_an_arc_may_be_cut_into_pieces(start: Pose, motion: Motion, pieces: int) -> None:
    whole, cut = arc_step(start, motion), start
    for _ in range(pieces):
        cut = arc_step(cut, Motion(motion.forward / pieces, motion.turn / pieces))
    assert (cut.x, cut.y) == approx((whole.x, whole.y), abs=1e-8)
    assert abs(wrap_angle(cut.yaw - whole.yaw)) < 1e-9


@given(poses(), st.floats(-1.0, 1.0), st.floats(-3e-6, 3e-6))
def test_nearly_straight_is_nearly_straight(start: Pose, way: float, turn: float) -> None:
    end = arc_step(start, Motion(way, turn))
    ahead = Pose(start.x + way * cos(start.yaw), start.y + way * sin(start.yaw))
    assert (end.x, end.y) == approx((ahead.x, ahead.y), abs=1e-5)


@given(poses(), motions)
def test_the_midpoint_rule_differs_by_the_square_of_the_turn_at_most(start: Pose, motion: Motion) -> None:
    """Chord against arc: sin(h)/h with h half the turn."""
    arc, middle = arc_step(start, motion), midpoint_step(start, motion)
    apart = hypot(arc.x - middle.x, arc.y - middle.y)
    assert apart <= abs(motion.forward) * motion.turn**2 / 24.0 + 1e-9
    assert abs(wrap_angle(arc.yaw - middle.yaw)) < 1e-9


@given(poses(), noisy)
def test_the_covariance_stays_symmetric_and_never_shrinks(pose: Pose, motion: Motion) -> None:
    before = np.diag([1e-4, 2e-4, 3e-4])
    after = propagate(before, pose, motion)
    assert after == approx(after.T, abs=1e-15)
    assert np.linalg.eigvalsh(after).min() >= -1e-15
    assert np.linalg.det(after) >= np.linalg.det(before) * (1.0 - 1e-9)


@given(poses(), noisy)
def test_the_covariance_is_that_of_the_step_s_numeric_derivatives(pose: Pose, motion: Motion) -> None:
    def step(values: np.ndarray) -> np.ndarray:
        end = midpoint_step(Pose(*values[:3]), Motion(values[3], values[4]))
        return np.array([end.x, end.y, pose.yaw + wrap_angle(end.yaw - pose.yaw)])

    at, slight = np.array([*numbers(pose), motion.forward, motion.turn]), 1e-6
    slopes = np.array([(step(at + d) - step(at - d)) / (2.0 * slight) for d in np.eye(5) * slight]).T
    before = np.diag([1e-4, 2e-4, 3e-4])
    inputs = np.zeros((5, 5))
    inputs[:3, :3] = before
    inputs[3, 3], inputs[4, 4] = motion.forward_variance, motion.turn_variance
    inputs[3, 4] = inputs[4, 3] = motion.shared
    expected = slopes @ inputs @ slopes.T
    assert propagate(before, pose, motion) == approx(expected, abs=1e-8, rel=1e-5)


def test_two_midpoint_steps_with_their_covariance() -> None:
    start = Pose()
    first = midpoint_step(start, STEP)
    assert numbers(first) == approx((0.5098406, 0.0127487, 0.05), abs=1e-6)
    covariance = propagate(np.zeros((3, 3)), start, STEP)
    assert np.diag(covariance) == approx([2.5478107e-5, 4.1475330e-5, 6.375e-4], abs=1e-11)
    assert covariance[0, 2] == approx(-1.5644204e-6, abs=1e-12)
    assert covariance[1, 2] == approx(1.62574195e-4, abs=1e-12)
    second = midpoint_step(first, STEP)
    assert numbers(second) == approx((1.0184069, 0.0509628, 0.1), abs=1e-6)
    covariance = propagate(covariance, first, STEP)
    x, y, yaw = (sqrt(variance) for variance in np.diag(covariance))
    assert (x, y) == approx((7.2126924e-3, 20.3267502e-3), abs=1e-9)
    assert degrees(yaw) == approx(2.0458685, abs=1e-6)


def test_the_exact_arc_of_the_first_step() -> None:
    assert numbers(arc_step(Pose(), STEP)) == approx((0.5097875, 0.0127473, 0.05), abs=1e-6)


def test_where_the_wheels_first_stand_is_the_origin() -> None:
    drive = odometry()
    assert drive.update(5, (123.0, -45.0)) == Pose()
    assert drive.travelled == 0.0
    assert not drive.covariance.any()


def test_a_turn_of_both_wheels_is_their_circumference() -> None:
    drive = odometry()
    drive.update(0, (1.0, 2.0))
    pose = drive.update(10 * MS, (1.0 + tau, 2.0 + tau))
    assert numbers(pose) == approx((0.06 * tau, 0.0, 0.0))
    assert drive.travelled == approx(0.06 * tau)


@given(steps)
def test_the_odometry_adds_up_the_arcs_and_their_doubts(ways: list[tuple[float, float]]) -> None:
    drive, pose, covariance, travelled = odometry(), Pose(), np.zeros((3, 3)), 0.0
    angles = (0.0, 0.0)
    drive.update(0, angles)
    for number, (left, right) in enumerate(ways, 1):
        moved = angles[0] + left, angles[1] + right
        motion = drive.kinematics.motion(angles, moved)
        drive.update(number * 10 * MS, moved)
        covariance = propagate(covariance, pose, motion)
        pose, angles = arc_step(pose, motion), moved
        travelled += abs(motion.forward)
    assert numbers(drive.pose) == approx(numbers(pose), abs=1e-9)
    assert drive.covariance == approx(covariance, abs=1e-12)
    assert drive.travelled == approx(travelled, abs=1e-12)


def test_the_covariance_of_a_pose_may_be_kept() -> None:
    drive = straight([10, 10])
    kept, copy = drive.covariance, drive.covariance.copy()
    drive.update(30 * MS, (40.0, 30.0))
    assert (kept == copy).all()


def test_a_motion_over_a_gap_is_ten_times_as_doubtful() -> None:
    steady, gapped = straight([10] * 5), straight([10] * 4 + [31])
    per_step = steady.covariance[0, 0] / 5.0
    assert gapped.covariance[0, 0] == approx((4.0 + 10.0) * per_step)
    assert numbers(gapped.pose) == numbers(steady.pose)


def test_two_late_readings_are_no_gap() -> None:
    assert (straight([10] * 4 + [30]).covariance == straight([10] * 5).covariance).all()


def test_after_a_restart_the_robot_may_have_gone_on_as_before() -> None:
    drive = straight([10, 10, 10, 20], restarted_at=3)
    assert drive.pose.x == approx(3 * 0.6)
    assert drive.covariance[0, 0] == approx(3 * SPREAD * 0.6 / 2.0 + 1.2**2)


def test_a_robot_that_stood_while_a_wheel_restarted_is_where_it_was() -> None:
    drive = odometry()
    for stamp_ms in (0, 10, 20):
        drive.update(stamp_ms * MS, (7.0, 7.0))
    drive.update(30 * MS, (7.0, 7.0), restarted=True)
    assert not drive.covariance.any()


def test_a_gyro_keeps_the_heading_when_a_wheel_spins() -> None:
    gyro = Gyro()
    drive = odometry()
    drive.yaw_fusion = YawFusion(gyro, 1e-8)
    angles = (0.0, 0.0)
    for stamp_ms in range(0, 4000, 10):
        gyro.add(stamp_ms * MS, 0.02)
        spins = 2.0 if stamp_ms >= 2000 else 0.0
        angles = angles[0], angles[1] + spins * 0.01
        drive.update(stamp_ms * MS, angles)
    assert drive.yaw_fusion.slipping
    alone = 2.0 * 2.0 * 0.06 / 0.32
    assert abs(drive.pose.yaw) < 0.01 < alone


def test_a_quarter_turn_on_the_spot() -> None:
    assert numbers(arc_step(Pose(1.0, 2.0), Motion(0.0, pi / 2.0))) == approx((1.0, 2.0, pi / 2.0))


def test_after_a_restart_the_pose_is_that_of_wheels_which_stood() -> None:
    """A log does not tell of restarts."""
    told, untold = odometry(), odometry()
    for drive in (told, untold):
        drive.yaw_fusion = YawFusion(Gyro(), 1e-6)
        for stamp_ms in range(0, 5000, 10):
            drive.yaw_fusion.gyro.add(stamp_ms * MS, 0.3 if stamp_ms >= 2000 else 0.0)
            angle = max(stamp_ms - 2000, 0) * 1e-3
            drive.update(stamp_ms * MS, (angle, angle * 4.2))
        drive.yaw_fusion.gyro.add(6000 * MS, 0.3)
    told.update(5100 * MS, (2.99, 2.99 * 4.2), restarted=True)
    untold.update(5100 * MS, (2.99, 2.99 * 4.2))
    assert numbers(told.pose) == numbers(untold.pose)
    assert told.covariance[2, 2] > untold.covariance[2, 2]
