"""Robots with wrong wheels drive right squares; what their odometry says of it is mended."""

from math import hypot, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.kinematics import Ackermann, Differential, Tricycle
from echogrid.mapping.odometry import Odometry
from echogrid.mapping.wheel_runs import (
    WheelRun,
    dead_reckoned,
    from_squares,
    is_square,
    square_errors,
    straight_error,
    straight_scale,
    straight_zero,
    with_zero,
)

SIDE = 4.0
NOMINAL = Differential(0.1, 0.1, 0.5, 1e-4)
CLOCKWISE, COUNTERCLOCKWISE = -1.0, 1.0

ratios = st.floats(0.98, 1.02)
factors = st.floats(0.93, 1.07)


def true_drive(ratio: float, factor: float) -> Differential:
    """As large wheels on average, unequal, and another track."""
    return Differential(0.2 / (ratio + 1.0), 0.2 / (1.0 / ratio + 1.0), 0.5 * factor, 1e-4)


def square(turn: float, drive: Differential, corners: int = 4) -> WheelRun:
    """What the wheels of that drive turn on a true square."""
    corner = turn * pi / 2.0 * drive.track / 2.0
    legs = [(SIDE, SIDE), (-corner, corner)] * corners
    ways = np.repeat([(left / 50.0, right / 50.0) for left, right in legs], 50, axis=0)
    return WheelRun(np.cumsum([(0.0, 0.0), *(ways / (drive.left_radius, drive.right_radius))], axis=0))


def squares(drive: Differential) -> list[WheelRun]:
    return [square(CLOCKWISE, drive), square(COUNTERCLOCKWISE, drive)]


def noisy(run: WheelRun, random: np.random.Generator) -> WheelRun:
    """1 mm of slip after 1 m of each wheel's way."""
    steps = np.diff(run.angles, axis=0)
    slip = random.normal(size=steps.shape) * 0.001 * np.sqrt(abs(steps) * 0.1) / 0.1
    return WheelRun(np.cumsum([(0.0, 0.0), *(steps + slip)], axis=0))


@given(st.lists(st.tuples(st.floats(-30, 30), st.floats(-30, 30)), min_size=2, max_size=20), ratios, factors)
def test_the_end_is_where_the_odometry_ends(
    angles: list[tuple[float, float]], ratio: float, factor: float
) -> None:
    drive = true_drive(ratio, factor)
    odometry = Odometry(drive)
    for stamp_ns, each in enumerate(angles):
        odometry.update(stamp_ns, each)
    end = dead_reckoned(WheelRun(np.array(angles)), drive)
    assert (end.x, end.y) == approx((odometry.pose.x, odometry.pose.y), abs=1e-6)
    assert end.travelled == approx(odometry.travelled)


@given(ratios, factors, ratios)
def test_squares_tell_the_true_wheels_and_track(ratio: float, factor: float, assumed: float) -> None:
    true = true_drive(ratio, factor)
    found = from_squares(squares(true), true_drive(assumed, 1.0))
    assert found.right_radius / found.left_radius == approx(ratio, abs=1e-5)
    assert found.track == approx(true.track, rel=1e-4)
    assert found.left_radius + found.right_radius == approx(0.2, rel=1e-12)


@given(ratios, factors)
def test_the_odometry_of_a_calibrated_robot_ends_where_it_did(ratio: float, factor: float) -> None:
    runs = squares(true_drive(ratio, factor))
    before, after = (square_errors(runs, drive).worst for drive in (NOMINAL, from_squares(runs, NOMINAL)))
    assert after <= before / 100.0 + 1e-6


@pytest.mark.parametrize("seed", range(10))
def test_slipping_wheels_are_mended_tenfold_by_five_squares_in_each_direction(seed: int) -> None:
    random = np.random.default_rng(seed)
    truth = squares(true_drive(0.99, 1.03))
    found = from_squares([noisy(run, random) for run in truth * 5], NOMINAL)
    assert square_errors(truth, found).worst < square_errors(truth, NOMINAL).worst / 10.0


def test_a_right_robot_is_left_alone() -> None:
    found = from_squares(squares(NOMINAL), NOMINAL)
    assert (found.left_radius, found.right_radius, found.track) == approx((0.1, 0.1, 0.5), abs=1e-9)


def test_an_end_beside_the_start_is_taken_into_account() -> None:
    true = true_drive(1.005, 0.98)
    ends = [dead_reckoned(run, true) for run in squares(NOMINAL)]
    driven_by_odometry = [
        WheelRun(run.angles, (end.x, end.y)) for run, end in zip(squares(NOMINAL), ends, strict=True)
    ]
    found = from_squares(driven_by_odometry, NOMINAL)
    assert found.right_radius / found.left_radius == approx(1.005, abs=1e-5)
    assert found.track == approx(true.track, rel=1e-3)


def test_squares_in_one_direction_tell_nothing() -> None:
    with pytest.raises(ValueError, match="both directions"):
        from_squares([square(CLOCKWISE, NOMINAL)] * 2, NOMINAL)


def test_the_scatter_is_that_of_single_runs_about_their_mean() -> None:
    turns = [square(turn, NOMINAL) for turn in (CLOCKWISE, CLOCKWISE, COUNTERCLOCKWISE, COUNTERCLOCKWISE)]
    runs = [WheelRun(run.angles, (0.03 * (-1) ** index, 0.0)) for index, run in enumerate(turns)]
    errors = square_errors(runs, NOMINAL)
    assert errors.scatter == approx(0.03)
    assert errors.worst == approx(0.0, abs=1e-9)
    assert errors.side == approx(SIDE)


@pytest.mark.parametrize("corners", [2, 3, 8])
def test_other_figures_are_no_squares(corners: int) -> None:
    assert is_square(dead_reckoned(square(CLOCKWISE, NOMINAL), NOMINAL))
    assert not is_square(dead_reckoned(square(CLOCKWISE, NOMINAL, corners), NOMINAL))


def test_a_turn_on_the_spot_is_no_square() -> None:
    angles = np.array([(0.0, 0.0), (-5.0 * pi, 5.0 * pi)])
    assert not is_square(dead_reckoned(WheelRun(angles), NOMINAL))


@given(st.floats(0.8, 1.2), st.floats(1.0, 20.0))
def test_straight_runs_tell_the_scale(scale: float, length: float) -> None:
    angle = length / (0.1 * scale)
    run = WheelRun(np.array([(0.0, 0.0), (angle, angle)]), (length, 0.0))
    assert straight_scale([run, run], NOMINAL) == approx(scale)
    assert straight_error([run], NOMINAL) == approx(abs(length - length / scale), abs=1e-9)


def test_wheels_which_stood_tell_no_scale() -> None:
    with pytest.raises(ValueError, match="did not turn"):
        straight_scale([WheelRun(np.zeros((5, 2)), (5.0, 0.0))], NOMINAL)


def test_the_worked_square_is_as_wrong_as_worked_out() -> None:
    true = Differential(0.2 / 2.003, 0.2 / (1.0 / 1.003 + 1.0), 0.495, 1e-4)
    ends = [dead_reckoned(square(turn, NOMINAL), true) for turn in (CLOCKWISE, COUNTERCLOCKWISE)]
    assert [(end.x, end.y) for end in ends] == [
        approx((-0.0653096, -0.0686191), abs=1e-6),
        approx((0.3358982, -0.2905241), abs=1e-6),
    ]
    assert max(hypot(end.x, end.y) for end in ends) == approx(0.4441080, abs=1e-6)


@pytest.mark.parametrize("kind", [Tricycle, Ackermann])
@given(zero=st.floats(-0.3, 0.3), scale=st.floats(0.8, 1.2), swing=st.floats(0.0, 0.2))
def test_straight_runs_of_a_steered_robot_tell_its_scale_and_its_steering_s_zero(
    kind: type[Tricycle | Ackermann], zero: float, scale: float, swing: float
) -> None:
    """It swings to either side, and ends as it looked at first."""
    drive = kind(0.1, 0.8, 1e-4, 1e-4)
    angle = 5.0 / (0.1 * scale)
    rows = [(angle * part / 100, zero + swing * sin(part * pi / 25)) for part in range(101)]
    run = WheelRun(np.array(rows))
    assert straight_zero([run], drive) == approx(zero, abs=1e-6)
    mended = with_zero(run, zero)
    end = dead_reckoned(mended, drive)
    measured = WheelRun(mended.angles, (hypot(end.x, end.y) * scale, 0.0))
    assert straight_scale([measured], drive) == approx(scale)


def test_a_steered_robot_that_stood_tells_no_zero() -> None:
    with pytest.raises(ValueError, match="did not turn"):
        straight_zero([WheelRun(np.zeros((5, 2)))], Tricycle(0.1, 0.8, 1e-4, 1e-4))


@pytest.mark.parametrize("kind", [Tricycle, Ackermann])
def test_a_steered_run_s_end_is_where_the_odometry_ends(kind: type[Tricycle | Ackermann]) -> None:
    drive = kind(0.1, 0.8, 1e-4, 1e-4)
    rows = [(0.5 * n, 0.6 * sin(0.1 * n)) for n in range(200)]
    odometry = Odometry(drive)
    for n, row in enumerate(rows):
        odometry.update(n, row)
    end = dead_reckoned(WheelRun(np.array(rows)), drive)
    assert (end.x, end.y) == approx((odometry.pose.x, odometry.pose.y), abs=1e-9)
    assert end.travelled == approx(odometry.travelled)
