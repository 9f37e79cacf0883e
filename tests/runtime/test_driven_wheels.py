"""Motors that are commanded: each driver with its emulated controller, which turns a wheel."""

from dataclasses import dataclass
from random import Random
from typing import Any

from pytest import approx, fixture, mark

from echogrid.drivers import registry
from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.throttle import Throttle
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.shaft import MotorShaft
from echogrid.emulation.models import WHEELS

MS = 1_000_000
SECOND = 1000 * MS
TICK = 5 * MS
FASTEST, ACCELERATION = 30.0, 20.0


@dataclass(frozen=True)
class Make:
    """A controller that can be driven."""

    driver: str
    settings: dict[str, Any]
    """Of its driver and its emulator."""
    options: dict[str, Any]
    """Of its emulator: it stops by itself when it hears nothing."""
    fault: str
    """What makes it stop, and keeps it from being enabled."""
    after: State
    """What it says while that lasts."""


MAKES = (
    Make("odrive-0.5", {"node": 3, "watchdog": True}, {}, "motor_failed", State.FAILED),
    Make("odrive-0.6", {"node": 3, "watchdog": True}, {}, "motor_failed", State.FAILED),
    Make("vesc", {"node": 3}, {}, "off", State.SILENT),
    Make("cia402", {"node": 3, "counts_per_turn": 4096}, {}, "tripped", State.FAILED),
)


class Trial:
    """A driver and its emulated controller on one bus, on a clock that jumps."""

    def __init__(self, make: Make, gear: float = 1.0) -> None:
        self.shaft = MotorShaft()
        settings = {"gear": gear, **make.settings, **make.options}
        node = WHEELS[make.driver].build("wheel", self.shaft, Random(1), settings)
        assert isinstance(node, CanNode)
        self.node = node
        self.bus = CanBus("can", 500_000, [node])
        self.bus.switch_on(SECOND)
        self.throttle = Throttle(FASTEST, ACCELERATION)
        driver: Any = registry.driver(make.driver)
        role = WheelRole("wheel", gear, FASTEST, self.throttle)
        self.driver = driver(role, driver.Settings(**make.settings))
        self.now_ns = SECOND
        self.sent: list[CanFrame] = []
        self.readings: list[WheelReading] = []

    def run(self, seconds: float, rate: float | None = None) -> None:
        """Go on so long, and ask for that rate all the while; None: for nothing."""
        end_ns = self.now_ns + round(seconds * SECOND)
        while self.now_ns < end_ns:
            self.now_ns += TICK
            if rate is not None:
                self.throttle.ask(self.now_ns, rate)
            step = self.driver.step(self.now_ns, self.bus.take(self.now_ns))
            self.bus.send(step.send, self.now_ns)
            self.sent += step.send
            self.readings += [reading for reading in step.readings if isinstance(reading, WheelReading)]

    def without_a_driver(self, seconds: float) -> None:
        """The process is gone."""
        self.now_ns += round(seconds * SECOND)
        self.bus.take(self.now_ns)

    @property
    def rate(self) -> float:
        """That of the wheel in truth."""
        return self.shaft.rate(self.now_ns)

    @property
    def state(self) -> State:
        health = self.driver.health(self.now_ns)
        assert isinstance(health.state, State)
        return health.state


@fixture(params=MAKES, ids=lambda make: make.driver)
def make(request: Any) -> Make:
    made: Make = request.param
    return made


@fixture
def trial(make: Make) -> Trial:
    return Trial(make)


@mark.parametrize("gear", [1.0, -7.5])
def test_a_wheel_turns_as_it_is_asked_to(make: Make, gear: float) -> None:
    trial = Trial(make, gear)
    trial.run(2.0)
    trial.run(1.0, 0.0)
    assert trial.throttle.obeyed
    trial.run(2.0, 6.0)
    assert trial.rate == approx(6.0, rel=0.01)
    trial.run(2.0, -4.0)
    assert trial.rate == approx(-4.0, rel=0.01)
    first, last = trial.readings[0], trial.readings[-1]
    assert last.angle - first.angle == approx(trial.shaft(last.stamp_ns), abs=0.3)
    trial.run(1.0, 0.0)
    assert trial.rate == 0.0


def test_nothing_that_touches_the_motor_is_sent_before_a_rate_is_asked_for(make: Make, trial: Trial) -> None:
    trial.run(5.0)
    asked, listening = trial.sent, Trial(make)
    listening.driver = registry.driver(make.driver)(
        WheelRole("wheel"), registry.driver(make.driver).Settings(**make.settings)
    )
    listening.run(5.0)
    assert asked == listening.sent


def test_a_rate_that_is_not_asked_for_anew_stops_the_wheel_until_zero_is_asked_for(trial: Trial) -> None:
    trial.run(2.0)
    trial.run(1.0, 0.0)
    trial.run(1.0, 6.0)
    trial.run(0.15)
    assert trial.rate == approx(6.0, rel=0.01)
    trial.run(0.35)
    assert trial.rate == 0.0
    trial.run(1.0, 6.0)
    assert trial.rate == 0.0
    trial.run(0.5, 0.0)
    trial.run(1.0, 6.0)
    assert trial.rate == approx(6.0, rel=0.01)


def test_when_the_process_is_gone_the_controller_stops_the_wheel_by_itself(trial: Trial) -> None:
    trial.run(2.0)
    trial.run(1.0, 0.0)
    trial.run(1.0, 6.0)
    trial.without_a_driver(1.5)
    assert trial.rate == 0.0
    trial.run(2.0, 0.0)
    trial.run(1.0, 6.0)
    assert trial.rate == approx(6.0, rel=0.01)


def test_after_a_fault_the_wheel_stands_until_it_is_asked_to_stand(make: Make, trial: Trial) -> None:
    trial.run(2.0)
    trial.run(1.0, 0.0)
    trial.run(1.0, 6.0)
    trial.node.fault(make.fault, trial.now_ns, SECOND)
    trial.run(0.9, 6.0)
    assert trial.state is make.after
    assert not trial.throttle.obeyed
    trial.run(4.0, 6.0)
    assert trial.rate == 0.0
    assert trial.state is State.WELL
    assert "command to stand" in trial.driver.health(trial.now_ns).message
    trial.run(1.5, 0.0)
    trial.run(1.0, 6.0)
    assert trial.rate == approx(6.0, rel=0.01)


def test_what_is_sent_last_stops_the_wheel_and_lets_it_go(trial: Trial) -> None:
    trial.run(2.0)
    trial.run(1.0, 0.0)
    trial.run(1.0, 6.0)
    trial.bus.send(trial.driver.parting(trial.now_ns), trial.now_ns)
    trial.without_a_driver(0.45)
    assert trial.rate == 0.0


def test_a_wheel_that_was_never_taken_is_left_as_it_is(trial: Trial) -> None:
    trial.run(2.0)
    assert tuple(trial.driver.parting(trial.now_ns)) == ()
