from hypothesis import given
from hypothesis.strategies import floats, integers, lists, tuples
from pytest import approx

from echogrid.emulation.devices.shaft import MotorShaft, Shaft
from echogrid.emulation.driven import DrivenBase

MS = 1_000_000
SECOND = 1000 * MS


def test_one_that_somebody_else_turns_cares_for_no_motor() -> None:
    shaft = Shaft.of(lambda now_ns: now_ns / SECOND)
    shaft.drive(50.0, 0)
    shaft.release(SECOND)
    assert shaft(2 * SECOND) == 2.0
    assert Shaft.of(shaft) is shaft


def test_its_motor_speeds_it_up_evenly_and_let_go_it_rolls_to_a_stop() -> None:
    shaft = MotorShaft(acceleration=10.0, friction=2.0)
    shaft.drive(5.0, SECOND)
    assert shaft(SECOND) == 0.0
    assert shaft(SECOND + 500 * MS) == approx(0.5 * 10.0 * 0.25)
    assert shaft(2 * SECOND) == approx(1.25 + 2.5)
    shaft.release(2 * SECOND)
    assert shaft.rate(3 * SECOND) == approx(3.0)
    assert shaft(60 * SECOND) == approx(3.75 + 5.0**2 / 2 / 2.0)
    assert shaft(SECOND + 500 * MS) == approx(1.25)


@given(lists(tuples(integers(1, 500), floats(-20, 20)), max_size=20))
def test_its_angle_never_jumps(commands: list[tuple[int, float]]) -> None:
    shaft, now_ns = MotorShaft(), 0
    for wait_ms, rate in commands:
        now_ns += wait_ms * MS
        before = shaft(now_ns), shaft.rate(now_ns)
        shaft.drive(rate, now_ns)
        assert (shaft(now_ns), shaft.rate(now_ns)) == approx(before, abs=1e-9)


def test_a_driven_base_goes_straight_and_turns_as_its_wheels_do() -> None:
    base = DrivenBase((1.0, 2.0, 0.0), 0, (0.1, 0.1), 0.4)
    for shaft in (base.left, base.right):
        shaft.drive(5.0, 0)
    x, y, yaw = base.pose(4 * SECOND)
    assert (x, y, yaw) == approx((1.0 + 0.1 * base.left(4 * SECOND), 2.0, 0.0))
    base.left.drive(-5.0, 4 * SECOND)
    assert base.pose(6 * SECOND)[2] == approx((base.right(6 * SECOND) - base.left(6 * SECOND)) * 0.1 / 0.4)
    assert base.pose(4 * SECOND) == approx((x, y, yaw))


def test_what_was_foreseen_is_forgotten_when_a_motor_is_told_otherwise() -> None:
    base = DrivenBase((0.0, 0.0, 0.0), 0, (0.1, 0.1), 0.4)
    for shaft in (base.left, base.right):
        shaft.drive(5.0, 0)
    assert base.pose(10 * SECOND)[0] > 4.0
    for shaft in (base.left, base.right):
        shaft.drive(0.0, SECOND)
    assert base.pose(10 * SECOND)[0] < 0.6
