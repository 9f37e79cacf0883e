"""Emulated gyros: their lines and frames as documented, and what is wrong with them."""

from math import pi, radians
from random import Random
from statistics import mean, stdev
from typing import Any

from pytest import approx, mark, raises

from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.gyro_dbc import GyroDbc, GyroDbcOptions
from echogrid.emulation.devices.gyro_text import GyroText, GyroTextOptions
from echogrid.emulation.errors import RobotSpecError
from echogrid.emulation.models import GYROS

MS = 1_000_000
SECOND = 1000 * MS
QUIET = {"bias_dps": 0.0, "noise_dps": 0.0}


def turning(now_ns: int) -> float:
    """A quarter of a turn a second, from the first second on."""
    return pi / 2.0 if now_ns >= SECOND else 0.0


def lines(seconds: float = 2.0, verb: str = "", seed: int = 1, **options: Any) -> list[bytes]:
    """What it prints; a fault begins after a second."""
    device = GyroText("gyro", turning, Random(seed), GyroTextOptions(**{**QUIET, **options}))
    line = SerialLine("line", device)
    line.switch_on(0)
    heard = b""
    for now_ns in range(0, round(seconds * SECOND) + 1, 100 * MS):
        heard += b"".join(line.take(now_ns))
        if verb and now_ns == SECOND:
            device.fault(verb, now_ns)
    return heard.split(b"\r\n")


def numbers(seconds: float = 2.0, verb: str = "", seed: int = 1, **options: Any) -> list[float]:
    return [float(line) for line in lines(seconds, verb, seed, **options)[:-1]]


@mark.parametrize(
    ("options", "number", "line"),
    [
        ({}, 12.5, b"12.5\r\n"),
        ({}, -0.0000015, b"-1.5e-06\r\n"),
        ({"key": "gz="}, 1.0, b"gz=1\r\n"),
        ({"column": 3}, 1.25, b"0,0,1.25\r\n"),
        ({"column": 2, "separator": " "}, 1.25, b"0 1.25\r\n"),
    ],
)
def test_a_line_is_as_documented(options: dict[str, Any], number: float, line: bytes) -> None:
    assert GyroTextOptions(**options).line(number) == line


@mark.parametrize(
    ("options", "number", "identifier", "data"),
    [
        ({}, 10.0, 0x1A0, "E8030700"),
        ({}, -10.0, 0x1A0, "18FC0700"),
        ({}, 1000.0, 0x1A0, "FF7F0700"),
        ({"step": 0.5, "identifier": 0x18FEF1FE}, -1.0, 0x18FEF1FE, "FEFF0700"),
    ],
)
def test_a_frame_is_as_documented(options: dict[str, Any], number: float, identifier: int, data: str) -> None:
    frame = GyroDbcOptions(**options).frame(number, 256 + 7)
    assert (frame.identifier, frame.data) == (identifier, bytes.fromhex(data))
    assert frame.extended == (identifier > 0x7FF)


def test_it_tells_how_fast_the_robot_turns_a_hundred_times_a_second() -> None:
    told = numbers()
    assert 175 <= len(told) <= 181
    assert set(told) == {0.0, 90.0}
    assert 98 <= told.count(90.0) <= 101


@mark.parametrize(
    ("options", "number"),
    [
        ({"unit": "rad/s"}, 1.5708),
        ({"scale": -1.0}, -90.0),
        ({"scale": 1.0 / 131.0}, 90.0 * 131.0),
        ({"bias_dps": 0.75}, 90.75),
        ({"scale_error": 0.02}, 91.8),
    ],
)
def test_its_number_is_the_rate_by_its_options(options: dict[str, Any], number: float) -> None:
    assert numbers(**options)[-1] == approx(number, rel=1e-5)


def test_its_noise_is_that_of_its_options_and_its_seed_s() -> None:
    told = numbers(11.0, noise_dps=0.3)[110:]
    assert mean(told) == approx(90.0, abs=0.05)
    assert stdev(told) == approx(0.3, rel=0.1)
    assert numbers(noise_dps=0.3) == numbers(noise_dps=0.3)
    assert numbers(noise_dps=0.3) != numbers(noise_dps=0.3, seed=2)


def test_one_that_drifts_says_ever_more() -> None:
    assert numbers(11.0, "drifting")[-1] == approx(92.0, abs=0.01)


def test_one_that_is_stuck_says_the_same() -> None:
    assert set(numbers(3.0, "stuck")) == {0.0}


def test_garbage_has_hardly_a_line() -> None:
    assert len(lines(3.0, "garbage")[-1]) > 400


def test_one_without_power_is_silent() -> None:
    assert len(numbers(3.0, "off")) < 82


def test_frames_come_a_hundred_times_a_second_and_are_counted() -> None:
    node = GyroDbc("gyro", turning, Random(1), GyroDbcOptions(**QUIET))
    bus = CanBus("can", 500_000, [node])
    bus.switch_on(0)
    frames = bus.take(2 * SECOND)
    assert 175 <= len(frames) <= 181
    assert [frame.data[2] for frame in frames] == list(range(len(frames)))
    assert frames[-1].data[:2] == (9000).to_bytes(2, "little")


@mark.parametrize("model", GYROS)
@mark.parametrize(
    "options", [{"period_ns": 1000}, {"unit": "turns"}, {"scale": 0.0}, {"noise_dps": -1.0}, {"colour": 1}]
)
def test_options_that_cannot_be_are_refused(model: str, options: dict[str, Any]) -> None:
    with raises(RobotSpecError, match=r"^gyro: "):
        GYROS[model].build("gyro", lambda _: radians(1.0), Random(1), options)
