"""The kernel's rangers and our driver of them: on the jumping clock, over a folder, over a socket."""

import os
import threading
import time
from collections.abc import Mapping
from errno import ENXIO
from itertools import pairwise
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis.strategies import floats, sampled_from
from pytest import approx, mark

from echogrid.drivers.clock import JumpingClock, MonotonicClock
from echogrid.drivers.device import Line, State
from echogrid.drivers.iio import Iio
from echogrid.drivers.readings import Outcome, RangeReading, Reading
from echogrid.drivers.role import RangerRole, Slot
from echogrid.drivers.sound import speed_of_sound
from echogrid.drivers.transports.ports import make_port
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RangerSpec, RobotSpec
from echogrid.emulation.scene import Echo
from echogrid.runtime.acquisition import ThreadedAcquisition, device_reports
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulation import Simulation

from .device_trial import Subject, Trial, course_of
from .fakes import MS, SECOND, Parrot, ScriptedPort
from .served import served

TOLD = speed_of_sound(20.0)
LONG_S = 10.0
RESOLUTION = {"srf04": 0.001, "ping": 0.001, "srf08": 0.00501, "maxbotix-mb1232": 0.00501}
"""m."""
NEAREST = {"srf04": 0.03, "ping": 0.03, "srf08": 0.04, "maxbotix-mb1232": 0.23}

SEEN = {
    **dict.fromkeys(("off", "unplug", "delayed"), State.MISSING),
    **dict.fromkeys(("stuck", "wrong"), State.WELL),
}
PULSE = SEEN | {"slow": State.WELL, "garbage": State.WELL}
CHIP = SEEN | {"slow": State.MISSING, "garbage": State.FAULTY, "nack_storm": State.MISSING}
STATES: Mapping[str, Mapping[str, State]] = {
    "srf04": PULSE,
    "ping": PULSE,
    "srf08": CHIP,
    "maxbotix-mb1232": CHIP,
}
"""What a fault looks like; noise on a wire is a pulse of some length, and not seen to be wrong."""
CASES = [(kind, verb, state) for kind, states in STATES.items() for verb, state in states.items()]

kinds = mark.parametrize("kind", STATES)


def subject(kind: str, **options: Any) -> Subject:
    return Subject("iio", {"device": kind}, options)


@kinds
@given(share=floats(0.0, 1.0), speed=sampled_from([325.0, TOLD, 355.0]))
@settings(max_examples=15)
def test_a_wall_is_seen_within_the_resolution(kind: str, share: float, speed: float) -> None:
    distance = NEAREST[kind] + share * (2.5 - NEAREST[kind])
    readings = Trial(subject(kind), distance, speed).run(2.0)
    assert len(readings) >= 5
    assert [reading.distance for reading in readings] == approx(
        [distance * TOLD / speed] * len(readings), abs=RESOLUTION[kind]
    )


@kinds
def test_nothing_is_told_as_such(kind: str) -> None:
    assert {reading.outcome for reading in Trial(subject(kind), None).run(2.0)} == {Outcome.NO_ECHO}


@mark.parametrize("no_echo_ms", [36, 38, 42, 60, 200])
def test_a_clone_says_nothing_in_its_own_way(no_echo_ms: int) -> None:
    trial = Trial(subject("srf04", no_echo_ns=no_echo_ms * MS), None)
    assert {reading.outcome for reading in trial.run(3.0)} == {Outcome.NO_ECHO}
    trial.wall.distance = 1.0
    trial.run(1.0)
    assert trial.run(1.0)[-1].distance == approx(1.0, abs=0.001)


@mark.parametrize(("kind", "verb", "state"), CASES, ids=str)
def test_each_fault_has_its_state_and_its_way_back(kind: str, verb: str, state: State) -> None:
    course = course_of(subject(kind), verb, 1.2, RESOLUTION[kind])
    assert course.state is state
    assert course.recovery_s < 3.0


@kinds
def test_a_bad_contact_comes_and_goes(kind: str) -> None:
    course = course_of(subject(kind), "intermittent", 1.2, RESOLUTION[kind])
    assert set(course.states) == {State.WELL, State.MISSING}
    assert course.recovery_s < 3.0


def test_the_garbage_of_a_chip_is_hardly_ever_believed() -> None:
    assert course_of(subject("srf08"), "garbage", 1.2, 1.0).outcomes[Outcome.ECHO] <= 1


@kinds
def test_the_moment_of_the_ping_is_within_its_error(kind: str) -> None:
    pins = Pins({"front": kind}, Slot(200 * MS, 0))
    readings = pins.run(2.0)
    moments_ns = [reading.stamp_ns - round(reading.distance / TOLD * SECOND) for reading in readings]
    assert len(moments_ns) >= 9
    for moment_ns, fired_ns, reading in zip(moments_ns, pins.fired_ns, readings, strict=False):
        assert abs(moment_ns - fired_ns) <= reading.stamp_error_ns


def test_two_of_one_kernel_that_shall_ping_at_once_ping_one_after_the_other() -> None:
    pins = Pins({"left": "left", "right": "right"}, Slot(200 * MS, 0))
    assert [reading.sensor for reading in pins.run(1.1)] == ["left", "right"] * 5
    assert all(later - first > 20 * MS for first, later in pairwise(pins.fired_ns))


def test_without_the_kernels_drivers_the_port_is_lost_and_comes_back() -> None:
    pins = Pins({"front": "srf04"}, Slot(200 * MS, 0))
    pins.robot.fault("pins", "unplug", pins.clock.now_ns(), SECOND)
    assert [reading.outcome for reading in pins.run(1.0)] == []
    assert device_reports([pins.pump], pins.clock.now_ns())[0].health.state is State.PORT_LOST
    assert {reading.outcome for reading in pins.run(3.0)} == {Outcome.ECHO}
    assert device_reports([pins.pump], pins.clock.now_ns())[0].health.state is State.WELL


class Pins:
    """Rangers (name: `device`) on an emulated kernel, all before a wall, with their drivers."""

    def __init__(self, rangers: Mapping[str, str], slot: Slot) -> None:
        self.fired_ns: list[int] = []
        self.clock, self._queue = JumpingClock(SECOND), ReadingQueue()
        air = Surroundings(lambda fire_ns: (Echo(1.2, 60.0, "wall"),), TOLD, ping=self.fired_ns.append)
        specs = tuple(
            RangerSpec(name, "iio", "pins", 0.0, 0.0, 0.0, {"device": device})
            for name, device in rangers.items()
        )
        robot = RobotSpec(0.1, 0.4, (BusSpec("pins", "iio"),), specs, ())
        self.robot = EmulatedRobot(robot, lambda _: air, lambda _side: lambda _now: 0.0)
        line = Line("pins", [ranger(name, device, slot) for name, device in rangers.items()])
        self.pump = Pump(line, self.robot.ports(self.clock)["pins"], self.clock, self._queue.put)
        self._simulation = Simulation(self.clock, [self.pump], self._queue)

    def run(self, for_s: float) -> list[RangeReading]:
        """The readings of so much time."""
        self._simulation.sleep_until_ns(self.clock.now_ns() + round(for_s * SECOND))
        return [reading for reading in self._queue.drain() if isinstance(reading, RangeReading)]


def ranger(name: str, device: str, slot: Slot | None = None) -> Iio:
    return Iio(RangerRole(name, 0.03, 4.0, slot, TOLD), Iio.Settings(device))


class BusyPort(ScriptedPort):
    """Always has something to give."""

    def read(self, timeout_s: float) -> list[bytes]:
        threading.Event().wait(0.001)
        return [b"x"]


def test_a_slow_ranger_of_the_kernel_holds_up_no_other_bus(tmp_path: Path) -> None:
    """Its file is a pipe, whose reader waits for a writer."""
    files = tmp_path / "iio:device0"
    files.mkdir()
    for name, text in (("name", "srf04\n"), ("in_distance_scale", "0.001000\n")):
        (files / name).write_text(text)
    raw, later = files / "in_distance_raw", tmp_path / "later"
    os.mkfifo(raw)
    later.write_text("2500\n")
    clock, queue = MonotonicClock(), ReadingQueue()
    pins = Pump(Line("pins", [ranger("front", "srf04")]), make_port("iio", str(tmp_path)), clock, queue.put)
    other = Pump(Line("other", [Parrot("other")]), BusyPort(), clock, queue.put)
    with ThreadedAcquisition([pins, other], queue) as acquisition:
        pipe = writer_once_it_is_read(raw)
        acquisition.drain()
        held_up = drained(acquisition, 50)
        later.replace(raw)
        os.write(pipe, b"1500\n")
        os.close(pipe)
        freed = drained(acquisition, 50)
        while not any(reading.sensor == "front" for reading in freed):
            freed += drained(acquisition, 1)
    assert {reading.sensor for reading in held_up} == {"other"}
    stamps_ns = [reading.stamp_ns for reading in held_up]
    assert max(after - before for before, after in pairwise(stamps_ns)) < SECOND
    assert next(reading for reading in freed if reading.sensor == "front").raw == b"1500"


def writer_once_it_is_read(pipe: Path) -> int:
    """The pipe's other end, when somebody waits for it."""
    give_up_ns = time.monotonic_ns() + round(LONG_S * SECOND)
    while time.monotonic_ns() < give_up_ns:
        try:
            return os.open(pipe, os.O_WRONLY | os.O_NONBLOCK)
        except OSError as error:
            assert error.errno == ENXIO
            threading.Event().wait(0.01)
    raise AssertionError("nobody reads the pipe")


def drained(acquisition: ThreadedAcquisition, count: int) -> list[RangeReading]:
    """So many readings."""
    readings: list[Reading] = []
    give_up_ns = time.monotonic_ns() + round(LONG_S * SECOND)
    while len(readings) < count:
        assert time.monotonic_ns() < give_up_ns, readings[-5:]
        threading.Event().wait(0.005)
        readings += acquisition.drain()
    return [reading for reading in readings if isinstance(reading, RangeReading)]


def test_an_emulated_kernel_in_another_process_is_read_over_its_socket(short_dir: Path) -> None:
    specs = [RangerSpec("front", "iio", "pins", 0.0, 0.0, 0.0, {"device": "front"})]
    with served(short_dir, {"pins": "iio"}, specs, 1.2):
        queue = ReadingQueue()
        port = make_port("iio", f"unix:{short_dir / 'pins.sock'}")
        pump = Pump(Line("pins", [ranger("front", "front")]), port, MonotonicClock(), queue.put)
        with ThreadedAcquisition([pump], queue) as acquisition:
            readings = drained(acquisition, 3)
    assert {reading.outcome for reading in readings} == {Outcome.ECHO}
    assert readings[0].distance == approx(1.2, abs=0.002)
