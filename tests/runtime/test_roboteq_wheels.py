"""Drivers and emulated channels of Roboteq controllers on one bus, on the jumping clock."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import cos, hypot, sin, tau
from random import Random
from typing import Any

from pytest import approx, mark, raises

from echogrid.drivers import registry
from echogrid.drivers.bus import CanFrame
from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.device import Device, Health, Line, State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.models import WHEELS
from echogrid.emulation.offices import office_tour
from echogrid.emulation.wires.memory import MemoryPort
from echogrid.runtime import evaluation
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.hardware_config import WheelConfig
from echogrid.runtime.lines import lines
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulated_run import START_NS
from echogrid.runtime.simulation import Simulation

MS = 1_000_000
SECOND_NS = 1000 * MS
BEGIN_NS = 5 * SECOND_NS
BIT_RATE = 125_000
PER_TURN = 2000.0
FASTEST = 20.0
LAG_S = 0.002
"""A count's time is known to half the time from the request to its reply."""
SDO: dict[str, Any] = {}
VARIABLE: dict[str, Any] = {"source": "variable"}
MINICAN: dict[str, Any] = {"source": "variable", "mode": "minican"}
ways = mark.parametrize("way", [SDO, VARIABLE, MINICAN], ids=["sdo", "variable", "minican"])


def to_and_fro(now_ns: int) -> float:
    """Many turns in both directions, at up to 12 rad/s."""
    t = now_ns / SECOND_NS
    return 24.0 * sin(0.5 * t) + 3.0 * cos(0.3 * t)


def onward(now_ns: int) -> float:
    """8 rad/s, for ever."""
    return 8.0 * now_ns / SECOND_NS


class Trial:
    """One bus with an emulated channel and its driver for each of the settings."""

    def __init__(self, *settings: dict[str, Any], angle: Callable[[int], float] = to_and_fro) -> None:
        self.angle = angle
        self.nodes: list[CanNode] = []
        self.wheels: list[Device[Any, Any]] = []
        driver = registry.driver("roboteq")
        for number, each in enumerate(settings):
            name = f"wheel {number}"
            node = WHEELS["roboteq"].build(name, angle, Random(number), {"node": 9, **each})
            assert isinstance(node, CanNode)
            self.nodes.append(node)
            own = {key: value for key, value in each.items() if key not in ("mode", "origin", "start")}
            chosen = driver.Settings(**{"node": 9, "counts_per_turn": PER_TURN, **own})
            self.wheels.append(driver(WheelRole(name, fastest=FASTEST), chosen))
        self.bus = CanBus("can", BIT_RATE, self.nodes)
        self.clock = JumpingClock(BEGIN_NS)
        self.bus.switch_on(BEGIN_NS)
        self.queue = ReadingQueue(100_000)
        port: MemoryPort[CanFrame, CanFrame] = MemoryPort(self.bus, self.clock)
        pump = Pump(Line("can", self.wheels), port, self.clock, self.queue.put)
        self.simulation = Simulation(self.clock, [pump], self.queue)
        self.readings: dict[str, list[WheelReading]] = {wheel.name: [] for wheel in self.wheels}
        self.health: list[Health] = []

    def run(self, seconds: float) -> list[State]:
        """Go on so long; what the first wheel told, the first of each state in a row."""
        before = len(self.health)
        for _ in range(round(seconds * 100)):
            self.simulation.sleep_until_ns(self.clock.now_ns() + 10 * MS)
            for reading in self.simulation.drain():
                assert isinstance(reading, WheelReading)
                self.readings[reading.wheel].append(reading)
            self.health.append(self.wheels[0].health(self.clock.now_ns()))
        told = [health.state for health in self.health[before:]]
        return told[:1] + [new for old, new in pairwise(told) if new is not old]

    def fail(self, verb: str, seconds: float) -> list[State]:
        """The first controller fails for so long; the states meanwhile."""
        self.nodes[0].fault(verb, self.clock.now_ns(), round(seconds * SECOND_NS))
        return self.run(seconds)

    def assert_never_silently_wrong(self, lag_s: float = LAG_S) -> int:
        """Each step is that of the true wheel, or none and flagged; the number of flags, all wheels'."""
        slack = 1.2 * tau / PER_TURN + lag_s * 12.0
        for readings in self.readings.values():
            for old, new in pairwise(readings):
                moved = 0.0 if new.discontinuity else self.angle(new.stamp_ns) - self.angle(old.stamp_ns)
                assert abs(new.angle - old.angle - moved) <= (1e-9 if new.discontinuity else slack)
        return sum(reading.discontinuity for readings in self.readings.values() for reading in readings)

    def turned(self) -> tuple[float, float]:
        """How far the first wheel was read to have turned since its first reading, and how far it has."""
        readings = self.readings[self.wheels[0].name]
        first, last = readings[0], readings[-1]
        return last.angle - first.angle, self.angle(last.stamp_ns) - self.angle(first.stamp_ns)


@ways
@mark.parametrize("angle", [to_and_fro, onward])
def test_every_turn_is_counted(way: dict[str, Any], angle: Callable[[int], float]) -> None:
    trial = Trial(way, angle=angle)
    assert trial.run(60.0)[-1] is State.WELL
    assert trial.assert_never_silently_wrong() == 0
    read, true = trial.turned()
    assert read == approx(true, abs=0.05)
    assert {health.state for health in trial.health[100:]} == {State.WELL}
    (readings,) = trial.readings.values()
    assert len(readings) > (700 if "mode" in way else 2900)


@ways
@mark.parametrize("origin", [(1 << 31) - 1000, -(1 << 31) + 1000])
def test_it_wraps_at_32_bits(way: dict[str, Any], origin: int) -> None:
    trial = Trial({**way, "origin": origin})
    trial.run(40.0)
    assert trial.assert_never_silently_wrong() == 0
    read, true = trial.turned()
    assert read == approx(true, abs=0.05)


def test_three_channels_of_one_controller_are_read_side_by_side() -> None:
    """Three heartbeats at once hold a reply back."""
    trial = Trial(*({"channel": channel} for channel in (1, 2, 3)))
    trial.run(10.0)
    assert trial.assert_never_silently_wrong(lag_s=0.004) == 0
    assert min(len(readings) for readings in trial.readings.values()) > 450
    assert {wheel.health(trial.clock.now_ns()).state for wheel in trial.wheels} == {State.WELL}


def test_a_brushless_motor_is_read_by_its_own_counter() -> None:
    trial = Trial({"encoder": "brushless", "channel": 2})
    trial.run(10.0)
    assert trial.assert_never_silently_wrong() == 0
    assert trial.health[-1].state is State.WELL


@ways
@mark.parametrize("verb", ["off", "unplug"])
@mark.parametrize("lasts_s", [0.05, 0.6, 3.0])
@mark.parametrize("since_s", [2.0, 3.7, 11.0])
def test_a_restart_is_one_discontinuity(
    way: dict[str, Any], verb: str, lasts_s: float, since_s: float
) -> None:
    trial = Trial(way)
    trial.run(since_s)
    states = trial.fail(verb, lasts_s) + trial.run(2.0)
    assert (State.SILENT in states) == (lasts_s > 0.1)
    assert trial.assert_never_silently_wrong() == 1
    assert states[-1] is State.WELL


@ways
@mark.parametrize("lasts_s", [1.0, 4.0])
def test_an_unplugged_adapter_loses_nothing_far_from_zero(way: dict[str, Any], lasts_s: float) -> None:
    trial = Trial(way, angle=onward)
    trial.run(15.0)
    trial.bus.fault("unplug", trial.clock.now_ns(), round(lasts_s * SECOND_NS))
    trial.run(lasts_s + 3.0)
    assert trial.assert_never_silently_wrong() == 0
    assert trial.health[-1].state is State.WELL


@ways
def test_a_bad_contact_gives_the_right_distance_or_a_flag(way: dict[str, Any]) -> None:
    trial = Trial(way)
    trial.run(4.0)
    trial.fail("intermittent", 10.0)
    trial.run(1.0)
    trial.assert_never_silently_wrong()
    assert trial.health[-1].state is State.WELL


@mark.parametrize(
    ("way", "verb", "state"),
    [
        (SDO, "overheated", State.HOT),
        (SDO, "emergency_stop", State.FAILED),
        (SDO, "sdo_deaf", State.STALLED),
        (SDO, "delayed", State.STALLED),
        (SDO, "garbage", State.STALLED),
        (SDO, "script_halted", State.WELL),
        (VARIABLE, "overheated", State.WELL),
        (VARIABLE, "emergency_stop", State.WELL),
        (VARIABLE, "sdo_deaf", State.WELL),
        (VARIABLE, "delayed", State.WELL),
        (VARIABLE, "garbage", State.FAULTY),
        (MINICAN, "delayed", State.WELL),
        (MINICAN, "garbage", State.FAULTY),
    ],
)
def test_a_fault_has_its_state_and_goes_with_it(way: dict[str, Any], verb: str, state: State) -> None:
    trial = Trial(way)
    trial.run(2.0)
    trial.nodes[0].fault(verb, trial.clock.now_ns(), 3 * SECOND_NS)
    assert trial.run(2.9)[-1] is state
    assert trial.run(2.1)[-1] is State.WELL


@mark.parametrize("verb", ["overheated", "emergency_stop", "sdo_deaf"])
def test_what_stops_its_motor_or_its_replies_loses_no_motion(verb: str) -> None:
    trial = Trial(SDO, angle=onward)
    trial.run(12.0)
    trial.fail(verb, 2.0)
    trial.run(2.0)
    assert trial.assert_never_silently_wrong() == 0


@mark.parametrize("way", [VARIABLE, MINICAN], ids=["variable", "minican"])
def test_a_halted_script_looks_like_a_wheel_that_stands_and_its_end_is_flagged(way: dict[str, Any]) -> None:
    """Nothing on the bus tells it: only a gyro does."""
    trial = Trial(way, angle=onward)
    trial.run(4.0)
    before = len(trial.readings["wheel 0"])
    assert trial.fail("script_halted", 2.0) == [State.WELL]
    stood = trial.readings["wheel 0"][before + 1 :]
    assert {reading.angle for reading in stood} == {stood[0].angle}
    trial.run(2.0)
    assert any(reading.discontinuity for reading in trial.readings["wheel 0"])


def test_a_robot_on_two_channels_of_one_controller_knows_where_it_is() -> None:
    config = evaluation.default_config()
    left, right = (
        WheelConfig(side, "roboteq", "wheel_bus", settings={"counts_per_turn": PER_TURN, "channel": channel})
        for channel, side in enumerate(("left", "right"), 1)
    )
    tape = evaluation.drive_tour(replace(config, wheel=(left, right)), 3, 2.0)
    stamp_ns, pose = evaluation.recorded(config, tape).poses[-1]
    found = evaluation.start_of(office_tour(), tape).compose(pose)
    x, y, _ = office_tour().pose((stamp_ns - START_NS) / SECOND_NS)
    assert hypot(found.x - x, found.y - y) < 0.005


@mark.parametrize(
    ("settings", "problem"),
    [
        ({"channel": 1}, "share counter 2104h:1 of node 1 of bus 'wheel_bus'"),
        ({"encoder": "relative"}, "encoder"),
        ({"object": 0x2108}, "object"),
    ],
)
def test_a_robot_file_can_neither_share_a_counter_nor_name_a_relative_one(
    settings: dict[str, Any], problem: str
) -> None:
    config = evaluation.default_config()
    wheels = tuple(
        WheelConfig(
            side, "roboteq", "wheel_bus", settings={"counts_per_turn": PER_TURN, "channel": 2, **settings}
        )
        for side in ("left", "right")
    )
    with raises(ConfigError, match=problem):
        lines(replace(config, wheel=wheels))
