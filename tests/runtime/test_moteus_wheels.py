"""Wheels on moteus controllers: driver and emulator on one bus and the jumping clock."""

from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from itertools import pairwise
from math import cos, hypot, sin, tau
from pathlib import Path
from random import Random
from typing import Any

import pytest

from echogrid.drivers import registry
from echogrid.drivers.bus import CanFrame
from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.device import Line, State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.errors import RobotSpecError
from echogrid.emulation.models import WHEELS
from echogrid.emulation.offices import office_tour
from echogrid.emulation.server import Server
from echogrid.emulation.wires.memory import MemoryPort
from echogrid.mapping.pose import wrap_angle
from echogrid.runtime import evaluation
from echogrid.runtime.config import Config
from echogrid.runtime.emulated import emulated_robot
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.hardware_config import WheelConfig
from echogrid.runtime.lines import lines
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.ports import real_ports
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulated_run import START_NS
from echogrid.runtime.simulation import Simulation

FASTEST = 20.0
FINENESS = 2e-5 * tau
DRIVER = registry.driver("moteus")


def to_and_fro(now_ns: int) -> float:
    """Many turns in both directions, at up to 12 rad/s."""
    t = now_ns / SECOND_NS
    return 24.0 * sin(0.5 * t) + 3.0 * cos(0.3 * t)


class Trial:
    """A driver and its emulated controller on one bus."""

    def __init__(self, angle: Callable[[int], float] = to_and_fro, **options: Any) -> None:
        self.clock = JumpingClock(SECOND_NS)
        node = WHEELS["moteus"].build("wheel", angle, Random(1), {"node": 9, **options})
        assert isinstance(node, CanNode)
        self.node = node
        self.bus = CanBus("can", 1_000_000, [self.node])
        self.bus.switch_on(SECOND_NS)
        self.driver = DRIVER(WheelRole("wheel", fastest=FASTEST), DRIVER.Settings(node=9))
        self.readings: list[WheelReading] = []
        self._angle = angle
        self._queue = ReadingQueue()
        port = MemoryPort(self.bus, self.clock)
        pump = Pump(Line("can", [self.driver]), port, self.clock, self._queue.put)
        self._simulation = Simulation(self.clock, [pump], self._queue)

    def run(self, seconds: float) -> list[WheelReading]:
        """Go on so long; the readings of it."""
        self._simulation.sleep_until_ns(self.clock.now_ns() + round(seconds * SECOND_NS))
        given = [reading for reading in self._queue.drain() if isinstance(reading, WheelReading)]
        self.readings += given
        return given

    @property
    def state(self) -> State:
        return self.driver.health(self.clock.now_ns()).state

    def assert_never_silently_wrong(self) -> int:
        """Each step is that of the true wheel, or none and flagged; the number of flags."""
        for old, new in pairwise(self.readings):
            moved = 0.0 if new.discontinuity else self._angle(new.stamp_ns) - self._angle(old.stamp_ns)
            late = FASTEST * 0.0005  # a reply tells of when it was made, and is stamped a little later
            assert abs(new.angle - old.angle - moved) <= (0.0 if new.discontinuity else FINENESS + late)
        return sum(reading.discontinuity for reading in self.readings)


def test_every_turn_is_counted() -> None:
    trial = Trial()
    trial.run(60.0)
    assert trial.state is State.WELL
    assert trial.assert_never_silently_wrong() == 0
    first, last = trial.readings[0], trial.readings[-1]
    moved = to_and_fro(last.stamp_ns) - to_and_fro(first.stamp_ns)
    assert last.angle - first.angle == pytest.approx(moved, abs=0.01)
    assert last.rate == pytest.approx(
        (to_and_fro(last.stamp_ns) - to_and_fro(last.stamp_ns - 1_000_000)) * 1000, abs=0.1
    )


def test_it_is_read_fifty_times_a_second_with_the_replys_stamp() -> None:
    trial = Trial()
    trial.run(1.0)
    assert len(trial.run(4.0)) == pytest.approx(200, abs=1)
    apart = {later.stamp_ns - sooner.stamp_ns for sooner, later in pairwise(trial.readings[-100:])}
    assert apart == {20_000_000}


@pytest.mark.parametrize("start", [3_000.0, -20_000.0, 100_000.0])
def test_far_from_zero_it_is_as_coarse_as_single_precision_and_no_more(start: float) -> None:
    trial = Trial(origin=start)
    trial.run(20.0)
    for old, new in pairwise(trial.readings):
        moved = to_and_fro(new.stamp_ns) - to_and_fro(old.stamp_ns)
        assert new.angle - old.angle == pytest.approx(moved, abs=0.01 + abs(start) * 2.0**-23 * tau)
    assert trial.state is State.WELL


@pytest.mark.parametrize("older", [False, True])
@pytest.mark.parametrize("verb", ["off", "unplug"])
@pytest.mark.parametrize("lasts_s", [0.05, 0.6, 3.0])
@pytest.mark.parametrize("since_s", [2.0, 3.7, 11.0])
def test_a_restart_is_one_discontinuity(older: bool, verb: str, lasts_s: float, since_s: float) -> None:
    trial = Trial(counts_milliseconds=int(not older))
    trial.run(since_s)
    trial.node.fault(verb, trial.clock.now_ns(), round(lasts_s * SECOND_NS))
    if lasts_s > 0.6:
        trial.run(lasts_s - 0.1)
        assert trial.state is State.MISSING
    trial.run(lasts_s + 2.0)
    assert trial.assert_never_silently_wrong() == 1
    assert trial.state is State.WELL


def test_an_unplugged_adapter_loses_no_turn() -> None:
    trial = Trial()
    trial.run(5.0)
    trial.bus.fault("unplug", trial.clock.now_ns(), 4 * SECOND_NS)
    trial.run(8.0)
    assert trial.assert_never_silently_wrong() == 0
    assert trial.state is State.WELL


def test_a_bad_contact_loses_no_turn() -> None:
    trial = Trial()
    trial.run(4.0)
    trial.node.fault("intermittent", trial.clock.now_ns(), 10 * SECOND_NS)
    trial.run(11.0)
    assert trial.assert_never_silently_wrong() == 0
    assert trial.state is State.WELL


@pytest.mark.parametrize(
    ("verb", "state", "flags"),
    [
        ("off", State.MISSING, 1),
        ("unplug", State.MISSING, 1),
        ("garbage", State.GARBLED, 0),
        ("delayed", State.STALLED, 0),
        ("overheated", State.HOT, 0),
        ("motor_failed", State.FAILED, 0),
        ("encoder_lost", State.FAILED, 1),
    ],
)
def test_a_fault_has_its_state_and_goes_with_it(verb: str, state: State, flags: int) -> None:
    trial = Trial()
    trial.run(2.0)
    trial.node.fault(verb, trial.clock.now_ns(), 3 * SECOND_NS)
    trial.run(2.9)
    assert trial.state is state
    trial.run(1.5)
    assert trial.state is State.WELL
    assert trial.assert_never_silently_wrong() == flags


def robot(right: str = "moteus", **bus: Any) -> Config:
    """The usual one with these on its wheels, and with other keys of their bus."""
    config = evaluation.default_config()
    wheels = (
        WheelConfig("left", "moteus", "wheel_bus", settings={"node": 1}),
        WheelConfig("right", right, "wheel_bus", settings={"node": 2}),
    )
    buses = tuple(replace(each, **bus) if each.name == "wheel_bus" else each for each in config.bus)
    return replace(config, wheel=wheels, bus=buses)


def test_a_bus_of_them_is_opened_for_can_fd(tmp_path: Path) -> None:
    config = robot(interface="virtual", bit_rate=None)
    (line,) = (line for line in lines(config) if line.name == "wheel_bus")
    with closing(real_ports(config, [line], tmp_path)["wheel_bus"]) as port:
        port.open()
        port.write([CanFrame(0x8001, bytes(12), extended=True, fd=True)])


@pytest.mark.parametrize(
    ("bus", "right", "text"),
    [
        ({"interface": "slcan"}, "moteus", "slcan has no CAN-FD: use an adapter that the kernel knows"),
        ({"interface": "virtual", "listen_only": True}, "moteus", "a moteus says nothing unless it is asked"),
        ({"interface": "virtual"}, "vesc", "differ on bus 'wheel_bus'"),
    ],
)
def test_where_they_cannot_be_is_refused_with_the_mend(
    tmp_path: Path, bus: dict[str, Any], right: str, text: str
) -> None:
    config = robot(right, **bus)
    with pytest.raises(ConfigError, match=text):
        real_ports(config, lines(config), tmp_path)


def test_an_emulated_robot_that_is_served_says_that_slcan_carries_none_of_it(tmp_path: Path) -> None:
    emulated = emulated_robot(robot(interface="slcan"), 0, 1)
    with pytest.raises(RobotSpecError, match=r"wheel_bus: slcan, .* leave the controllers that speak it"):
        Server(emulated, tmp_path / "robot", JumpingClock(0)).__enter__()


def test_a_robot_on_two_of_them_knows_where_it_is() -> None:
    config = robot(interface="virtual", bit_rate=None)
    recording = evaluation.recorded(config, tape := evaluation.drive_tour(config, 3, 4.0))
    stamp_ns, pose = recording.poses[-1]
    found = evaluation.start_of(office_tour(), tape).compose(pose)
    x, y, yaw = office_tour().pose((stamp_ns - START_NS) / SECOND_NS)
    assert hypot(found.x - x, found.y - y) < 0.02
    assert abs(wrap_angle(found.yaw - yaw)) < 0.01
