"""The helm on the built-in robot, emulated and driven, on a clock that jumps."""

from collections.abc import Iterator
from typing import Any

from pytest import approx, fixture

from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.readings import WheelReading
from echogrid.emulation.robot import EmulatedRobot
from echogrid.mapping.twist import Twist
from echogrid.runtime import robot_file
from echogrid.runtime.drive_run import drive_loop, pumped, wheel_lines
from echogrid.runtime.emulated import DEFAULT_ROBOT, emulated_robot
from echogrid.runtime.helm import SETTLE_NS, STANDSTILL, Helm, HelmState
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulation import Simulation

SECOND = 1_000_000_000


class Bridge:
    """The helm, and the robot beneath it."""

    def __init__(self) -> None:
        config = robot_file.load(DEFAULT_ROBOT)
        self.clock, queue = JumpingClock(SECOND), ReadingQueue()
        devices, driving = wheel_lines(config)
        self.robot: EmulatedRobot = emulated_robot(config, SECOND, 1, driven=True)
        ports: dict[str, Any] = dict(self.robot.ports(self.clock))
        self._simulation = Simulation(self.clock, pumped(devices, ports, self.clock, queue), queue)
        self._ticks: Iterator[int] = drive_loop(self._simulation, config).ticks(NEVER_NS)
        self.helm = Helm(driving)
        self.asked = STANDSTILL
        self.rates = {"left": 0.0, "right": 0.0}

    def run(self, seconds: float, twist: Twist) -> set[HelmState]:
        """The states that it was in meanwhile."""
        until_ns, states = self.clock.now_ns() + round(seconds * SECOND), set()
        while self.clock.now_ns() < until_ns:
            self.turn(twist)
            states.add(self.helm.state)
        return states

    def turn(self, twist: Twist) -> None:
        now_ns = next(self._ticks)
        self.rates |= {
            each.wheel: each.rate for each in self._simulation.drain() if isinstance(each, WheelReading)
        }
        self.asked = self.helm.steer(now_ns, twist, self._simulation.report(now_ns))

    def pause(self, seconds: float) -> None:
        self._simulation.sleep_until_ns(self.clock.now_ns() + round(seconds * SECOND))


@fixture
def bridge() -> Bridge:
    return Bridge()


AHEAD = Twist(0.3, 0.2)


def test_it_enables_the_motors_at_rest_and_drives_then(bridge: Bridge) -> None:
    bridge.turn(AHEAD)
    assert (bridge.helm.state, bridge.asked) == (HelmState.READYING, STANDSTILL)
    assert bridge.run(3.0, AHEAD) == {HelmState.READYING, HelmState.DRIVING}
    assert (bridge.asked.speed, bridge.asked.turn_rate) == approx((0.3, 0.2))
    assert bridge.rates["right"] > bridge.rates["left"] > 0.0
    assert bridge.helm.stops == 0


def test_a_motor_that_fails_stops_the_robot_until_it_is_well_again(bridge: Bridge) -> None:
    bridge.run(3.0, AHEAD)
    bridge.robot.fault("left", "motor_failed", bridge.clock.now_ns(), SECOND)
    bridge.run(0.9, AHEAD)
    assert (bridge.helm.state, bridge.asked, bridge.helm.stops) == (HelmState.READYING, STANDSTILL, 1)
    assert bridge.rates == approx({"left": 0.0, "right": 0.0})
    bridge.run(3.0, AHEAD)
    assert bridge.helm.state is HelmState.DRIVING


def test_after_a_pause_it_stands_before_it_drives_again(bridge: Bridge) -> None:
    bridge.run(3.0, AHEAD)
    bridge.pause(2.0)
    bridge.turn(AHEAD)
    assert (bridge.helm.state, bridge.asked) == (HelmState.READYING, STANDSTILL)
    assert bridge.run(0.9 * SETTLE_NS / SECOND, AHEAD) == {HelmState.READYING}
    assert HelmState.DRIVING in bridge.run(2.0, AHEAD)
    assert bridge.helm.stops == 1


def test_it_lets_the_motors_go(bridge: Bridge) -> None:
    bridge.run(3.0, AHEAD)
    bridge.run(1.0, STANDSTILL)
    bridge.helm.release()
    bridge.pause(0.5)
    assert bridge.helm.state is HelmState.RELEASED
    bridge.turn(AHEAD)
    assert bridge.asked == STANDSTILL
