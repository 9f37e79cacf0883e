"""Drivers and emulated drives of CiA 402 on one bus, on the jumping clock: the right distance, or a flag."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import cos, degrees, hypot, sin
from random import Random
from typing import Any

import pytest

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.cia402 import Cia402Axis
from echogrid.drivers.cia402_settings import Cia402Settings
from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.device import Health, Line, State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.throttle import Throttle
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.cia402 import Cia402Drive, Cia402Options
from echogrid.emulation.devices.shaft import MotorShaft
from echogrid.emulation.offices import office_tour
from echogrid.emulation.wires.memory import MemoryPort
from echogrid.mapping.pose import wrap_angle
from echogrid.runtime import evaluation
from echogrid.runtime.hardware_config import WheelConfig
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulated_run import START_NS
from echogrid.runtime.simulation import Simulation

MS = 1_000_000
SECOND_NS = 1000 * MS
BEGIN_NS = 5 * SECOND_NS
COUNTS_PER_TURN = 4096
FASTEST = 20.0


def to_and_fro(now_ns: int) -> float:
    """Many turns in both directions, at up to 12 rad/s."""
    t = now_ns / SECOND_NS
    return 24.0 * sin(0.5 * t) + 3.0 * cos(0.3 * t)


class Trial:
    """One bus with an axis for each of the settings, and the drives to them."""

    def __init__(
        self,
        *settings: dict[str, Any],
        angle: Callable[[int], float] = to_and_fro,
        throttle: Throttle | None = None,
        **options: Any,
    ) -> None:
        self.angle = angle
        chosen = [
            Cia402Settings(**{"counts_per_turn": COUNTS_PER_TURN, "node": number, **each})
            for number, each in enumerate(settings or ({},), 1)
        ]
        self.drives = [
            Cia402Drive(
                f"drive {each.node}", angle, Random(each.node), Cia402Options(node=each.node, **options)
            )
            for each in chosen
        ]
        self.axes = [
            Cia402Axis(WheelRole(str(each.node), fastest=FASTEST, throttle=throttle), each) for each in chosen
        ]
        self.bus = CanBus("can", 500_000, self.drives)
        self.clock = JumpingClock(BEGIN_NS)
        self.bus.switch_on(BEGIN_NS)
        self.queue = ReadingQueue(100_000)
        port: MemoryPort[CanFrame, CanFrame] = MemoryPort(self.bus, self.clock)
        self.pump = Pump(Line("can", self.axes), port, self.clock, self.queue.put)
        self.simulation = Simulation(self.clock, [self.pump], self.queue)
        self.readings: list[WheelReading] = []
        self.health: list[Health] = []

    def run(self, seconds: float, each_tick: Callable[[int], None] = lambda _: None) -> list[State]:
        """Go on so long; what the first axis told, the first of each state in a row."""
        before = len(self.health)
        for _ in range(round(seconds * 100)):
            self.simulation.sleep_until_ns(self.clock.now_ns() + 10 * MS)
            each_tick(self.clock.now_ns())
            self.readings += [each for each in self.simulation.drain() if isinstance(each, WheelReading)]
            self.health.append(self.axes[0].health(self.clock.now_ns()))
        told = [health.state for health in self.health[before:]]
        return told[:1] + [new for old, new in pairwise(told) if new is not old]

    def fail(self, verb: str, seconds: float) -> list[State]:
        """The first drive fails for so long; the states meanwhile."""
        self.drives[0].fault(verb, self.clock.now_ns(), round(seconds * SECOND_NS))
        return self.run(seconds)

    def assert_never_silently_wrong(self) -> int:
        """Each step of each wheel is the true one, or none and flagged; the number of flags."""
        flags = 0
        for name in {reading.wheel for reading in self.readings}:
            for old, new in pairwise([each for each in self.readings if each.wheel == name]):
                moved = 0.0 if new.discontinuity else self.angle(new.stamp_ns) - self.angle(old.stamp_ns)
                assert abs(new.angle - old.angle - moved) <= 0.01
                flags += new.discontinuity
        return flags


@pytest.mark.parametrize(
    ("settings", "options"),
    [
        ({}, {}),
        ({"sync": "produce", "period_ms": 20}, {}),
        ({"tpdo": 4, "status_tpdo": 3, "heartbeat_ms": 50}, {"origin": (1 << 31) - 5000}),
        ({"range_counts": 10_000}, {"range_counts": 10_000}),
        ({"velocity_units": 60.0}, {"velocity_units": 60.0, "origin": -(1 << 31) + 5000}),
    ],
)
def test_every_turn_is_counted_over_all_wraps(settings: dict[str, Any], options: dict[str, Any]) -> None:
    trial = Trial(settings, **options)
    trial.run(30.0)
    assert trial.assert_never_silently_wrong() == 0
    first, last = trial.readings[0], trial.readings[-1]
    assert last.angle - first.angle == pytest.approx(
        to_and_fro(last.stamp_ns) - to_and_fro(first.stamp_ns), abs=0.01
    )
    assert last.stamp_ns - first.stamp_ns > 29 * SECOND_NS
    assert {health.state for health in trial.health[100:]} == {State.WELL}
    rate = (to_and_fro(last.stamp_ns) - to_and_fro(last.stamp_ns - MS)) * 1000
    assert last.rate == pytest.approx(rate, abs=0.2)


def test_two_drives_share_a_bus_and_one_axis_sends_sync_for_both() -> None:
    trial = Trial({"sync": "produce"}, {"sync": "expect"})
    trial.run(3.0)
    assert trial.assert_never_silently_wrong() == 0
    by_wheel = [[each for each in trial.readings if each.wheel == name] for name in ("1", "2")]
    assert min(len(each) for each in by_wheel) > 240
    before = len(by_wheel[1])
    trial.fail("off", 2.0)
    assert len([each for each in trial.readings if each.wheel == "2"]) > before + 190


@pytest.mark.parametrize("verb", ["off", "unplug", "reset"])
@pytest.mark.parametrize("lasts_s", [0.05, 0.6, 3.0])
def test_a_restart_is_one_flagged_discontinuity(verb: str, lasts_s: float) -> None:
    trial = Trial()
    trial.run(3.7)
    states = trial.fail(verb, lasts_s)
    assert (State.SILENT in states) == (lasts_s > 0.4 and verb != "reset")
    trial.run(2.0)
    assert trial.assert_never_silently_wrong() == 1
    assert trial.health[-1].state is State.WELL


@pytest.mark.parametrize(
    ("verb", "state", "flags"),
    [
        ("tripped", State.FAILED, 0),
        ("encoder_lost", State.FAILED, 1),
    ],
)
def test_a_fault_has_its_state_and_goes_with_it(verb: str, state: State, flags: int) -> None:
    trial = Trial()
    trial.run(2.0)
    assert trial.fail(verb, 2.9)[-1] is state
    trial.run(3.0)
    assert trial.health[-1].state is State.WELL
    assert trial.assert_never_silently_wrong() == flags


def test_late_frames_are_not_noticed() -> None:
    trial = Trial()
    trial.run(2.0)
    assert trial.fail("delayed", 3.0) == [State.WELL]
    assert trial.run(3.0) == [State.WELL]


def test_after_garbage_it_is_well_again() -> None:
    trial = Trial()
    trial.run(2.0)
    assert trial.fail("garbage", 3.0)[-1] in (State.STALLED, State.MISSING)
    trial.run(3.0)
    assert trial.health[-1].state is State.WELL


def test_after_a_bad_contact_it_is_well_again() -> None:
    trial = Trial()
    trial.run(2.0)
    assert {State.WELL, State.SILENT} <= set(trial.fail("intermittent", 10.0))
    trial.run(3.0)
    assert trial.health[-1].state is State.WELL
    trial.assert_never_silently_wrong()


@pytest.mark.parametrize(("lasts_s", "flags"), [(0.2, 0), (1.0, 0), (30.0, 1)])
def test_an_unplugged_adapter_is_the_right_distance_or_a_flag(lasts_s: float, flags: int) -> None:
    def onward(now_ns: int) -> float:
        return 8.0 * now_ns / SECOND_NS

    trial = Trial(angle=onward)
    trial.run(10.0)
    trial.bus.fault("unplug", trial.clock.now_ns(), round(lasts_s * SECOND_NS))
    trial.run(lasts_s + 3.0)
    assert trial.assert_never_silently_wrong() == flags
    assert trial.health[-1].state is State.WELL


def test_a_service_that_starts_late_finds_a_drive_that_is_silent() -> None:
    """Without a heartbeat a drive says nothing after its boot-up message; it must be asked."""
    trial = Trial()
    trial.bus.advance(BEGIN_NS + 3 * SECOND_NS)
    trial.bus.take(BEGIN_NS + 3 * SECOND_NS)
    trial.clock.sleep_until_ns(BEGIN_NS + 3 * SECOND_NS)
    trial.run(1.0)
    assert trial.health[-1].state is State.WELL
    assert "restarts" not in trial.health[-1].counts


def driven() -> tuple[Trial, Throttle, MotorShaft]:
    """A drive whose motor turns its wheel, and the throttle for it."""
    shaft, throttle = MotorShaft(), Throttle(10.0, 5.0)
    trial = Trial(angle=shaft, throttle=throttle)
    trial.run(1.0)
    return trial, throttle, shaft


def test_a_wheel_turns_as_it_is_asked_and_stands_when_it_is_let_go() -> None:
    trial, throttle, shaft = driven()
    trial.run(1.0, lambda now_ns: throttle.ask(now_ns, 0.0))
    assert throttle.obeyed
    trial.run(3.0, lambda now_ns: throttle.ask(now_ns, -6.0))
    assert shaft.rate(trial.clock.now_ns()) == pytest.approx(-6.0, rel=1e-3)
    throttle.release()
    trial.run(2.0)
    assert shaft.rate(trial.clock.now_ns()) == 0.0
    assert trial.health[-1].state is State.WELL
    assert "emergencies" not in trial.health[-1].counts
    assert trial.assert_never_silently_wrong() == 0


def test_without_a_fresh_command_the_wheel_stands_enabled() -> None:
    trial, throttle, shaft = driven()
    trial.run(1.0, lambda now_ns: throttle.ask(now_ns, 0.0))
    trial.run(2.0, lambda now_ns: throttle.ask(now_ns, 6.0))
    trial.run(0.5)
    assert shaft.rate(trial.clock.now_ns()) == 0.0
    assert throttle.obeyed


def test_a_drive_whose_master_is_gone_stops_by_itself() -> None:
    trial, throttle, shaft = driven()
    trial.run(1.0, lambda now_ns: throttle.ask(now_ns, 0.0))
    trial.run(2.0, lambda now_ns: throttle.ask(now_ns, 6.0))
    now_ns = trial.clock.now_ns()
    trial.bus.advance(now_ns + 400 * MS)
    assert shaft.rate(now_ns + 400 * MS) == pytest.approx(6.0, rel=1e-3)
    trial.bus.advance(now_ns + 1500 * MS)
    assert shaft.rate(now_ns + 1500 * MS) == 0.0
    assert [frame.data[:2] for frame in trial.bus.take(now_ns + 1500 * MS) if frame.identifier == 0x081] == [
        b"\x30\x81"
    ]


def test_a_driven_wheel_stops_with_the_port_that_is_closed() -> None:
    trial, throttle, shaft = driven()
    trial.run(1.0, lambda now_ns: throttle.ask(now_ns, 0.0))
    trial.run(2.0, lambda now_ns: throttle.ask(now_ns, 6.0))
    trial.simulation.stop()
    now_ns = trial.clock.now_ns() + 300 * MS
    trial.bus.advance(now_ns)
    assert shaft.rate(now_ns) == 0.0
    emergencies = [frame for frame in trial.bus.take(now_ns + 3 * SECOND_NS) if frame.identifier == 0x081]
    assert emergencies == []


@pytest.mark.parametrize("verb", ["tripped", "reset", "off"])
def test_a_driven_wheel_that_has_failed_turns_again_after_a_command_to_stand(verb: str) -> None:
    trial, throttle, shaft = driven()
    trial.run(1.0, lambda now_ns: throttle.ask(now_ns, 0.0))
    trial.run(2.0, lambda now_ns: throttle.ask(now_ns, 6.0))
    trial.drives[0].fault(verb, trial.clock.now_ns(), SECOND_NS)
    trial.run(4.0, lambda now_ns: throttle.ask(now_ns, 6.0))
    assert shaft.rate(trial.clock.now_ns()) == 0.0
    assert "a command to stand" in trial.health[-1].message
    trial.run(1.0, lambda now_ns: throttle.ask(now_ns, 0.0))
    trial.run(2.0, lambda now_ns: throttle.ask(now_ns, 6.0))
    assert shaft.rate(trial.clock.now_ns()) == pytest.approx(6.0, rel=1e-3)


def test_a_driven_wheel_behind_a_replugged_adapter_turns_again_after_a_command_to_stand() -> None:
    trial, throttle, shaft = driven()
    trial.run(1.0, lambda now_ns: throttle.ask(now_ns, 0.0))
    trial.run(2.0, lambda now_ns: throttle.ask(now_ns, 6.0))
    trial.bus.fault("unplug", trial.clock.now_ns(), 3 * SECOND_NS)
    trial.run(6.0, lambda now_ns: throttle.ask(now_ns, 6.0))
    assert shaft.rate(trial.clock.now_ns()) == 0.0
    assert trial.health[-1].state is State.WELL
    trial.run(1.0, lambda now_ns: throttle.ask(now_ns, 0.0))
    trial.run(2.0, lambda now_ns: throttle.ask(now_ns, 6.0))
    assert shaft.rate(trial.clock.now_ns()) == pytest.approx(6.0, rel=1e-3)
    assert "8130" not in trial.health[-1].message


def test_a_robot_on_two_of_them_knows_where_it_is() -> None:
    config = evaluation.default_config()
    left, right = (
        WheelConfig(
            name, "cia402", "wheel_bus", settings={"node": node, "counts_per_turn": 4096, "sync": sync}
        )
        for node, name, sync in ((1, "left", "produce"), (2, "right", "expect"))
    )
    config = replace(config, wheel=(left, right))
    tape = evaluation.drive_tour(config, 3, 8.0)
    stamp_ns, pose = evaluation.recorded(config, tape).poses[-1]
    found = evaluation.start_of(office_tour(), tape).compose(pose)
    x, y, yaw = office_tour().pose((stamp_ns - START_NS) / SECOND_NS)
    assert hypot(found.x - x, found.y - y) < 0.01
    assert degrees(abs(wrap_angle(found.yaw - yaw))) < 0.1
