"""MaxBotix rangers and those with FF H L SUM frames, and their emulated devices: in memory, on a terminal."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import Any

from hypothesis import given, settings
from hypothesis.strategies import floats, sampled_from
from pytest import approx, mark

from echogrid.drivers import registry
from echogrid.drivers.clock import MonotonicClock
from echogrid.drivers.device import State
from echogrid.drivers.maxbotix_models import MODELS
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole
from echogrid.drivers.sound import speed_of_sound
from echogrid.drivers.transports.serial import SerialPort
from echogrid.emulation.devices.ff_parts import FF_PARTS
from echogrid.emulation.devices.maxbotix_kinds import KINDS
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RangerSpec, RobotSpec
from echogrid.emulation.scene import Echo
from echogrid.emulation.server import Server

from .device_trial import Subject, Trial, course_of

TOLD = speed_of_sound(20.0)
"""m/s, what the drivers are told of the air."""
INCH, CENTIMETRE, MILLIMETRE = 147e-6 * TOLD / 4, 58e-6 * TOLD / 4, 0.0005
"""m: half of what each number stands for."""
LV = Subject("maxbotix", {"model": "MB1010"})
RESOLUTIONS: list[tuple[Subject, float]] = [
    *((Subject("maxbotix", {"model": model}), INCH) for model in ("MB1010", "MB1001")),
    *((Subject("maxbotix", {"model": model}), CENTIMETRE) for model in ("MB1240", "MB7052", "MB1260")),
    *(
        (Subject("maxbotix", {"model": model}), MILLIMETRE)
        for model in ("MB1013", "MB1403", "MB7389", "MB7386")
    ),
    *((Subject("a02yyuw", {"part": part}), MILLIMETRE) for part in FF_PARTS),
    *((Subject("ff-on-demand", {"part": part}), MILLIMETRE) for part in ("jsn-sr04t", "aj-sr04m")),
]
ON_DEMAND = Subject("ff-on-demand")
HRXL = Subject("maxbotix", {"model": "MB7388"})
EACH = [(LV, INCH), (HRXL, MILLIMETRE), (Subject("a02yyuw"), MILLIMETRE)]
"""Those which send by themselves."""


def name(subject: object) -> str | None:
    """Of a test."""
    return " ".join((subject.driver, *subject.settings.values())) if isinstance(subject, Subject) else None


def test_driver_and_emulator_know_the_same_models() -> None:
    assert set(MODELS) == set(KINDS)


@mark.parametrize(("subject", "resolution"), RESOLUTIONS, ids=name)
@given(distance=floats(0.51, 3.7), speed=sampled_from([325.0, TOLD, 355.0]))
@settings(max_examples=8)
def test_a_wall_is_seen_within_the_resolution(
    subject: Subject, resolution: float, distance: float, speed: float
) -> None:
    trial = Trial(subject, distance, speed)
    trial.run(1.0)
    readings = trial.run(1.5)
    has_thermometer = resolution == MILLIMETRE
    expected = distance if has_thermometer else distance * TOLD / speed
    assert len(readings) >= 5
    assert [reading.distance for reading in readings] == approx(
        [expected] * len(readings), abs=resolution * 1.0001
    )


@mark.parametrize("subject", [subject for subject, _ in RESOLUTIONS], ids=name)
def test_nothing_is_told_as_such(subject: Subject) -> None:
    assert {reading.outcome for reading in Trial(subject, None).run(2.0)} == {Outcome.NO_ECHO}


def test_a_part_that_is_silent_without_an_echo_is_silent() -> None:
    trial = Trial(Subject("a02yyuw", options={"no_echo": -1}), None)
    assert trial.run(2.0) == []
    assert trial.state is State.SILENT


def test_on_demand_silence_is_no_echo_only_where_the_user_says_so() -> None:
    for silent_s, outcomes, state in ((0.0, set(), State.MISSING), (60.0, {Outcome.NO_ECHO}, State.WELL)):
        trial = Trial(Subject("ff-on-demand", {"silent_s": silent_s}, {"no_echo": -1}), 1.0)
        trial.run(1.0)
        trial.wall.distance = None
        trial.run(0.3)
        assert {reading.outcome for reading in trial.run(2.0)} == outcomes
        assert trial.state is state


def test_a_board_with_another_sum_is_read_by_a_driver_that_is_told_so() -> None:
    for driver in ("a02yyuw", "ff-on-demand"):
        told = Trial(Subject(driver, {"header_summed": False}), 1.2)
        assert {reading.distance for reading in told.run(2.0)} == {1.2}
        not_told = Trial(Subject(driver, options={"header_summed": False}), 1.2)
        assert not_told.run(2.0) == []
        assert not_told.state is State.GARBLED


def test_a_ranger_of_another_family_is_garbled() -> None:
    trial = Trial(Subject("maxbotix", {"model": "MB1010"}, {"model": "MB7389"}), 1.2)
    assert trial.run(3.0) == []
    assert trial.state is State.GARBLED


@mark.parametrize(("subject", "resolution"), EACH, ids=name)
@mark.parametrize(
    ("verb", "state"),
    [
        ("off", State.SILENT),
        ("unplug", State.PORT_LOST),
        ("garbage", State.GARBLED),
        *((verb, State.WELL) for verb in ("stuck", "wrong", "slow", "delayed")),
    ],
)
def test_each_fault_of_one_that_sends_by_itself_has_its_state_and_its_way_back(
    subject: Subject, resolution: float, verb: str, state: State
) -> None:
    course = course_of(subject, verb, 1.2, 1.0001 * resolution)
    assert set(course.states) == {state}
    assert course.recovery_s < 1.5


@mark.parametrize(
    ("verb", "states"),
    [
        ("off", {State.MISSING}),
        ("unplug", {State.PORT_LOST}),
        ("garbage", {State.GARBLED}),
        ("stuck", {State.WELL}),
        ("wrong", {State.WELL}),
        ("slow", {State.MISSING, State.STALLED}),
        ("delayed", {State.MISSING, State.STALLED}),
    ],
)
def test_each_fault_of_one_on_demand_has_its_state_and_its_way_back(verb: str, states: set[State]) -> None:
    course = course_of(ON_DEMAND, verb, 1.2, MILLIMETRE)
    assert set(course.states) <= states
    assert course.recovery_s < 3.0


@mark.parametrize(("subject", "resolution"), [*EACH, (ON_DEMAND, MILLIMETRE)], ids=name)
def test_a_bad_contact_comes_and_goes(subject: Subject, resolution: float) -> None:
    course = course_of(subject, "intermittent", 1.2, 1.0001 * resolution)
    assert set(course.states) <= {State.WELL, State.SILENT, State.MISSING, State.STALLED}
    assert set(course.outcomes) == {Outcome.ECHO}
    assert course.recovery_s < 3.0


@contextmanager
def served(folder: Path, driver: str, options: dict[str, Any]) -> Iterator[str]:
    """The terminal of an emulated ranger before a wall."""
    robot = RobotSpec(
        0.1, 0.4, (BusSpec("port", "serial"),), (RangerSpec("front", driver, "port", 0, 0, 0, options),), ()
    )
    wall = Surroundings(lambda fire_ns: (Echo(1.5, 40.0, "wall"),), TOLD)
    stop = threading.Event()
    with Server(
        EmulatedRobot(robot, lambda _: wall, lambda _: lambda _: 0.0), folder, MonotonicClock()
    ) as server:
        thread = threading.Thread(target=server.run, args=(stop,))
        thread.start()
        try:
            yield str(folder / "port")
        finally:
            stop.set()
            thread.join()


@mark.parametrize(
    ("driver", "shared", "baud", "state"),
    [
        *(("a02yyuw", {}, baud, state) for baud, state in ((9600, State.WELL), (4800, State.GARBLED))),
        ("maxbotix", {"model": "MB1010"}, 9600, State.WELL),
        ("maxbotix", {"model": "MB1010"}, 19200, State.GARBLED),
        *(("ff-on-demand", {}, baud, state) for baud, state in ((9600, State.WELL), (4800, State.MISSING))),
    ],
)
def test_on_a_terminal_of_the_wrong_speed_it_says_what_to_look_for(
    short_dir: Path, driver: str, shared: dict[str, Any], baud: int, state: State
) -> None:
    """One on demand does not even understand its trigger."""
    maker = registry.driver(driver)
    device = maker(RangerRole("front", 0.1, 4.0, None, TOLD), maker.Settings(**shared))
    line, clock = maker.line("line", [device]), MonotonicClock()
    with served(short_dir, driver, shared) as address:
        port = SerialPort(address, baud=baud)
        port.open()
        until_s = monotonic() + 20.0
        while device.health(clock.now_ns()).state is not state and monotonic() < until_s:
            step = line.step(clock.now_ns(), port.read(0.02))
            port.write(step.send)
        port.close()
    health = device.health(clock.now_ns())
    assert health.state is state
    assert state is State.WELL or "9600 baud" in health.message
