"""One emulated ranger with its driver before a wall, on the jumping clock: what they see, how faults show."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.device import State
from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.models import RANGERS
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RangerSpec, RobotSpec
from echogrid.emulation.scene import Echo
from echogrid.runtime import lone_device
from echogrid.runtime.acquisition import device_reports
from echogrid.runtime.lines import line_of
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulation import Simulation

SECOND_NS = 1_000_000_000
LOUD = 60.0
"""dB over the threshold."""
_LOOK_NS = SECOND_NS // 20
_BEFORE_S, _SETTLED_S, _FAULT_S, _AFTER_S = 3.0, 2.5, 6.0, 12.0


@dataclass(frozen=True, slots=True)
class Subject:
    """A ranger to be tried."""

    driver: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, int | float | str] = field(default_factory=dict)
    """Of the emulated device, beside those which it shares with its driver."""


@dataclass(slots=True)
class Wall:
    """All that is heard, and what may be moved."""

    distance: float | None
    """m; None: nothing is there."""

    def __call__(self, fire_ns: int) -> tuple[Echo, ...]:
        """The scene."""
        del fire_ns
        return () if self.distance is None else (Echo(self.distance, LOUD, "wall"),)


class Trial:
    """A ranger, its driver, and a wall."""

    def __init__(self, subject: Subject, distance: float | None, speed_of_sound: float = 343.21) -> None:
        """`speed_of_sound` is that of the emulated air; the driver is told 20 degC."""
        self.wall = Wall(distance)
        self.clock = JumpingClock(SECOND_NS)
        config = lone_device.on_port(subject.driver, "port", subject.settings)
        known = {option.name for option in fields(RANGERS[subject.driver].options)}
        shared = {key: value for key, value in subject.settings.items() if key in known}
        spec = RangerSpec(
            subject.driver, subject.driver, "port", 0.0, 0.0, 0.0, {**shared, **subject.options}
        )
        robot = RobotSpec(0.1, 0.4, (BusSpec("port", config.bus[0].kind),), (spec,), ())
        surroundings = Surroundings(self.wall, speed_of_sound)
        self.robot = EmulatedRobot(robot, lambda _: surroundings, lambda _side: lambda _now: 0.0)
        self._name = subject.driver
        self._queue = ReadingQueue()
        self._pump = Pump(line_of(config), self.robot.ports(self.clock)["port"], self.clock, self._queue.put)
        self._simulation = Simulation(self.clock, [self._pump], self._queue)

    def run(self, for_s: float) -> list[RangeReading]:
        """The readings of so much time."""
        self._simulation.sleep_until_ns(self.clock.now_ns() + round(for_s * SECOND_NS))
        return [reading for reading in self._queue.drain() if isinstance(reading, RangeReading)]

    @property
    def state(self) -> State:
        """How the device says it is."""
        (report,) = device_reports([self._pump], self.clock.now_ns())
        return report.health.state

    def fault(self, verb: str, for_s: float) -> None:
        """Let the ranger fail for so long."""
        self.robot.fault(self._name, verb, self.clock.now_ns(), round(for_s * SECOND_NS))


@dataclass(frozen=True, slots=True)
class FaultCourse:
    """What a fault did."""

    states: Counter[State]
    """While it lasted and had settled: how often each was seen."""
    outcomes: Counter[Outcome]
    """Of the readings meanwhile."""
    recovery_s: float
    """From its end to a right reading of a device that is well; infinite if that did not come."""

    @property
    def state(self) -> State:
        """The one that was seen most often."""
        return self.states.most_common(1)[0][0]


def course_of(subject: Subject, verb: str, distance: float, tolerance: float) -> FaultCourse:
    """What a fault of a ranger before a wall (m) does; a right reading is one within the tolerance (m)."""
    trial = Trial(subject, distance)
    trial.run(_BEFORE_S)
    trial.fault(verb, _FAULT_S)
    trial.run(_SETTLED_S)
    states: Counter[State] = Counter()
    outcomes: Counter[Outcome] = Counter()
    until_ns = trial.clock.now_ns() + round((_FAULT_S - _SETTLED_S) * SECOND_NS)
    while trial.clock.now_ns() < until_ns:
        outcomes.update(reading.outcome for reading in trial.run(_LOOK_NS / SECOND_NS))
        states[trial.state] += 1
    return FaultCourse(states, outcomes, _recovery_s(trial, distance, tolerance))


def _recovery_s(trial: Trial, distance: float, tolerance: float) -> float:
    ended_ns = trial.clock.now_ns()
    while (since_s := (trial.clock.now_ns() - ended_ns) / SECOND_NS) < _AFTER_S:
        right = any(abs(reading.distance - distance) <= tolerance for reading in trial.run(0.05))
        if right and trial.state is State.WELL:
            return since_s + _LOOK_NS / SECOND_NS
    return float("inf")
