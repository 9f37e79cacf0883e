from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.emulation.devices.shaft import MotorShaft, Shaft
from echogrid.emulation.devices.slip import SlippingShaft
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RobotSpec, WheelSpec

SECOND = 1_000_000_000


def rolling(now_ns: int) -> float:
    return 2.0 * now_ns / SECOND


@given(st.integers(0, 5 * SECOND), st.integers(0, 5 * SECOND), st.integers(0, 20 * SECOND))
def test_a_wheel_that_slips_turns_on_and_what_it_slipped_stays(
    start_ns: int, lasts_ns: int, now_ns: int
) -> None:
    shaft = SlippingShaft(Shaft(rolling))
    shaft.lose_grip(start_ns)
    shaft.grip(start_ns + lasts_ns)
    slipped = 3.0 * min(max(now_ns - start_ns, 0), lasts_ns) / SECOND
    assert shaft(now_ns) == approx(rolling(now_ns) + slipped)


def test_spells_add_up() -> None:
    shaft = SlippingShaft(Shaft(rolling))
    for start_s in (1, 3):
        shaft.lose_grip(start_s * SECOND)
        shaft.grip((start_s + 1) * SECOND)
    shaft.lose_grip(8 * SECOND)
    assert shaft(9 * SECOND) == approx(18.0 + 3 * 3.0)


def test_its_motor_turns_it_as_before() -> None:
    motor = MotorShaft(acceleration=10.0, friction=5.0)
    shaft = SlippingShaft(motor)
    shaft.drive(10.0, 0)
    assert shaft(2 * SECOND) == approx(15.0)
    shaft.release(2 * SECOND)
    assert motor.rate(4 * SECOND) == 0.0


def test_each_wheel_of_a_robot_has_the_fault() -> None:
    wheels = (
        WheelSpec("left", "vesc", "can", "left", {"node": 0}),
        WheelSpec("right", "vesc", "can", "right", {"node": 1}),
    )
    spec = RobotSpec(0.1, 0.4, (BusSpec("can", "can"),), (), wheels)
    robot = EmulatedRobot(spec, lambda _: Surroundings(lambda _: (), 343.2), lambda _: rolling)
    assert {name: "slip" in verbs for name, verbs in robot.verbs().items()} == {
        "left": True,
        "right": True,
        "can": False,
    }
    robot.fault("left", "slip", SECOND, SECOND)
    assert [fault.verb for fault in robot.active_faults(SECOND)] == ["slip"]
    assert robot.active_faults(3 * SECOND) == ()
