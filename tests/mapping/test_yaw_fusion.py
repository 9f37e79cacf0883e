from math import radians

from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.gyro import Gyro
from echogrid.mapping.kinematics import Motion
from echogrid.mapping.yaw_fusion import YawFusion

MS = 1_000_000
STEP = 10 * MS
NOISE = 1e-6
STILL = Motion(0.0, 0.0)


def fusion(rate: float, bias: float = 0.0, seconds: float = 5.0) -> tuple[YawFusion, int]:
    """After two seconds of standing the gyro tells of a turn; the stamp at which it begins."""
    gyro = Gyro()
    both = YawFusion(gyro, NOISE)
    for stamp_ns in range(0, round(seconds * 1e9), STEP):
        gyro.add(stamp_ns, bias + (rate if stamp_ns >= 2000 * MS else 0.0))
    for start_ns in range(0, 1900 * MS, STEP):
        both.fused(start_ns, start_ns + STEP, STILL)
    return both, 2000 * MS


@given(st.floats(-1.0, 1.0), st.floats(-0.05, 0.05), st.floats(1e-9, 1e-2), st.floats(-0.9, 0.9))
def test_the_turn_lies_between_both_and_is_surer_than_either(
    rate: float, bias: float, variance: float, correlation: float
) -> None:
    both, start_ns = fusion(rate, bias, 2.1)
    turn, noise = rate * 0.01 + radians(0.1), NOISE * 0.01
    forward_variance = 1e-6
    motion = Motion(
        0.01, turn, forward_variance, variance, correlation * (variance * forward_variance) ** 0.5
    )
    fused = both.fused(start_ns, start_ns + STEP, motion)
    assert rate * 0.01 - 1e-9 <= fused.turn <= turn + 1e-9
    assert fused.turn_variance == approx(1.0 / (1.0 / variance + 1.0 / noise))
    assert fused.forward_variance <= forward_variance
    assert fused.shared**2 <= fused.forward_variance * fused.turn_variance * (1.0 + 1e-9)


def test_without_a_bias_the_wheels_alone_are_believed() -> None:
    gyro = Gyro()
    for stamp_ns in range(0, 1000 * MS, STEP):
        gyro.add(stamp_ns, 1.0)
    motion = Motion(0.1, 0.2, 1e-4, 1e-4, 0.0)
    assert YawFusion(gyro, NOISE).fused(0, STEP, motion) == motion


def test_where_the_gyro_is_silent_the_wheels_alone_are_believed() -> None:
    both, start_ns = fusion(0.0)
    motion = Motion(0.1, 0.2, 1e-4, 1e-4, 0.0)
    late_ns = start_ns + 60_000 * MS
    assert both.fused(late_ns, late_ns + STEP, motion) == motion
    assert not both.slipping


def test_wheels_and_gyro_which_agree_do_not_slip() -> None:
    both, start_ns = fusion(0.5)
    for step in range(200):
        both.fused(start_ns + step * STEP, start_ns + (step + 1) * STEP, Motion(0.001, 0.005, 1e-6, 1e-6))
        assert not both.slipping


def test_half_a_degree_apart_within_a_second_is_slip_and_the_gyro_is_trusted() -> None:
    both, start_ns = fusion(0.0)
    each = radians(0.11)
    slips, turns = [], []
    for step in range(8):
        motion = Motion(0.001, each, 1e-6, 1e-6, 5e-7)
        fused = both.fused(start_ns + step * STEP, start_ns + (step + 1) * STEP, motion)
        slips.append(both.slipping)
        turns.append(fused.turn)
    assert slips == [False] * 4 + [True] * 4
    assert turns[-1] == approx(0.0, abs=1e-9)
    assert both.fused(start_ns + 9 * STEP, start_ns + 10 * STEP, motion).forward_variance == approx(1e-5)


def test_slip_is_over_a_second_after_it_ended() -> None:
    both, start_ns = fusion(0.0)
    both.fused(start_ns, start_ns + STEP, Motion(0.0, radians(2.0), 1e-6, 1e-6))
    for step in range(1, 101):
        assert both.slipping
        both.fused(start_ns + step * STEP, start_ns + (step + 1) * STEP, STILL)
    assert not both.slipping


def test_a_slow_disagreement_is_not_slip() -> None:
    both, start_ns = fusion(0.0)
    for step in range(290):
        both.fused(
            start_ns + step * STEP, start_ns + (step + 1) * STEP, Motion(0.001, radians(0.004), 1e-6, 1e-6)
        )
        assert not both.slipping


def test_the_bias_is_not_taken_in_the_half_second_after_a_stop() -> None:
    gyro = Gyro()
    both = YawFusion(gyro, NOISE)
    for stamp_ns in range(0, 3000 * MS, STEP):
        gyro.add(stamp_ns, 0.4 if stamp_ns < 500 * MS else 0.01)
    for start_ns in range(0, 2900 * MS, STEP):
        both.fused(start_ns, start_ns + STEP, STILL)
    assert gyro.bias == approx(0.01, abs=4e-3)


def test_the_bias_is_not_taken_while_the_wheels_turn() -> None:
    gyro = Gyro()
    both = YawFusion(gyro, NOISE)
    for stamp_ns in range(0, 3000 * MS, STEP):
        gyro.add(stamp_ns, 0.4)
    for start_ns in range(0, 2900 * MS, STEP):
        both.fused(start_ns, start_ns + STEP, Motion(0.0, 0.004, 1e-6, 1e-6))
    assert not gyro.settled


def test_slips_and_their_time_are_counted() -> None:
    both, start_ns = fusion(0.0)
    for step in range(250):
        turn = radians(2.0) if step in (10, 150) else 0.0
        both.fused(start_ns + step * STEP, start_ns + (step + 1) * STEP, Motion(0.0, turn, 1e-6, 1e-6))
    assert both.slips == 2
    assert both.slipped_ns == 2 * 100 * STEP


def test_the_bias_is_not_taken_over_a_time_in_which_a_wheel_may_have_restarted() -> None:
    gyro = Gyro()
    both = YawFusion(gyro, NOISE)
    for stamp_ns in range(0, 4000 * MS, STEP):
        gyro.add(stamp_ns, 0.01 if stamp_ns < 2000 * MS else 0.4)
    for start_ns in range(0, 2000 * MS, STEP):
        both.fused(start_ns, start_ns + STEP, STILL)
    both.fused(2000 * MS, 3900 * MS, STILL)
    assert gyro.bias == approx(0.01, abs=4e-3)
