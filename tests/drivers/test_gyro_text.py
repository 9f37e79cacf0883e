from itertools import pairwise
from math import radians
from random import Random
from re import escape
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from pytest import approx, mark, raises

from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.device import Level, State
from echogrid.drivers.gyro_line import LONGEST, LineFinder
from echogrid.drivers.gyro_text import GyroText
from echogrid.drivers.readings import GyroReading
from echogrid.drivers.role import GyroRole

MS = 1_000_000
SECOND = 1000 * MS
TICK_NS = 10 * MS
ROLE = GyroRole("gyro")
FINITE = st.floats(-1e6, 1e6)


def gyro(**settings: Any) -> GyroText:
    """One which has seen the end of a line already."""
    device = GyroText(ROLE, GyroText.Settings(**settings))
    device.step(0, [b"\n"])
    return device


def rates(device: GyroText, *chunks: bytes) -> list[float]:
    told = [device.step((n + 1) * TICK_NS, [chunk]).readings for n, chunk in enumerate(chunks)]
    return [each.rate for readings in told for each in readings if isinstance(each, GyroReading)]


def cut(data: bytes, places: list[int]) -> list[bytes]:
    edges = sorted({0, len(data), *(place % (len(data) + 1) for place in places)})
    return [data[start:end] for start, end in pairwise(edges)]


@mark.parametrize(
    ("line", "settings", "rate"),
    [
        (b"12.5\n", {}, radians(12.5)),
        (b"-0.25\r\n", {"unit": "rad/s"}, -0.25),
        (b"1.5e-1\r", {"unit": "rad/s"}, 0.15),
        (b" +.5 \n", {"unit": "rad/s"}, 0.5),
        (b"1.0, 2.0, -3.0\n", {"column": 3}, radians(-3.0)),
        (b"1234  0.1\t-4\n", {"column": 3, "separator": " "}, radians(-4.0)),
        (b"gz=7.5\n", {"key": "gz="}, radians(7.5)),
        (b"ax:1 gx:2 gz: 3\n", {"key": "gz:", "separator": ";"}, None),
        (b"ax:1;gx:2;gz: 3\n", {"key": "gz:", "separator": ";"}, radians(3.0)),
        (b"131\n", {"scale": 1.0 / 131.0}, radians(1.0)),
        (b"90\n", {"scale": -1.0}, radians(-90.0)),
        (b"nan\n", {}, None),
        (b"-inf\n", {}, None),
        (b"1_000\n", {}, None),
        (b"0x10\n", {}, None),
        (b"\xff1.0\n", {}, None),
        (b"2000.1\n", {}, None),
        (b"1e99\n", {}, None),
        (b"1e999\n", {}, None),
        (b"\n", {}, None),
    ],
)
def test_a_line_is_a_rate(line: bytes, settings: dict[str, Any], rate: float | None) -> None:
    assert rates(gyro(**settings), line) == ([] if rate is None else [approx(rate)])


@given(st.lists(FINITE, min_size=1, max_size=20), st.lists(st.integers(0, 10_000), max_size=20))
def test_however_the_lines_are_cut_the_numbers_are_the_same(numbers: list[float], places: list[int]) -> None:
    finder = LineFinder(",", 1, "")
    finder.feed(b"\n")
    stream = b"".join(f"{number!r}\r\n".encode() for number in numbers)
    found = [number for chunk in cut(stream, places) for number, _ in finder.feed(chunk)]
    assert found == numbers
    assert finder.bad_lines == 0


@given(st.binary(max_size=2000), FINITE, st.lists(st.integers(0, 10_000), max_size=9))
def test_after_any_noise_the_second_line_is_understood(
    noise: bytes, number: float, places: list[int]
) -> None:
    finder = LineFinder(",", 1, "")
    for chunk in cut(noise, places):
        finder.feed(chunk)
    finder.feed(b"0\n")
    assert finder.feed(f"{number!r}\n".encode()) == [(number, f"{number!r}".encode())]


def test_half_a_line_at_the_start_is_no_number() -> None:
    device = GyroText(ROLE, GyroText.Settings())
    assert rates(device, b"2.75\n", b"-12.75\n") == [approx(radians(-12.75))]


def test_half_a_line_before_a_loss_of_the_port_is_forgotten() -> None:
    device = gyro()
    device.step(TICK_NS, [b"12"])
    device.lost(2 * TICK_NS)
    assert rates(device, b"3\n", b"4\n") == [approx(radians(4.0))]


def test_half_a_line_before_a_pause_is_forgotten() -> None:
    device = gyro()
    device.step(TICK_NS, [b"12"])
    assert device.step(TICK_NS + SECOND, [b"3\n"]).readings == ()


def test_a_line_without_an_end_is_kept_no_longer_than_a_line_may_be() -> None:
    finder = LineFinder(",", 1, "")
    finder.feed(b"\n")
    assert finder.feed(b"1" * (LONGEST + 1)) == []
    assert finder.bad_lines == 1
    assert finder.feed(b"1\n") == []
    assert finder.feed(b"2\n") == [(2.0, b"2")]


def test_the_stamp_is_when_the_line_began_less_the_lag() -> None:
    device = gyro(baud=9600, lag_ms=5.0)
    (reading,) = device.step(100 * MS, [b"1.5\n"]).readings
    assert isinstance(reading, GyroReading)
    assert reading.stamp_ns == approx(100 * MS - 4 * 10 * SECOND / 9600 - 5 * MS, abs=10)
    assert (reading.gyro, reading.raw) == ("gyro", b"1.5")


def test_of_several_lines_at_once_the_last_counts() -> None:
    device = gyro()
    assert rates(device, b"1\n2\n3\n") == [approx(radians(3.0))]
    assert device.health(TICK_NS).counts["overtaken lines"] == 2


def test_it_sends_nothing_and_waits_for_nothing() -> None:
    step = gyro().step(TICK_NS, [b"1\n"])
    assert (step.send, step.deadline_ns) == ((), NEVER_NS)


def state(device: GyroText, now_ns: int) -> State:
    return device.health(now_ns).state


def test_each_trouble_has_its_state() -> None:
    device = GyroText(ROLE, GyroText.Settings())
    assert state(device, 0) is State.SILENT
    device.step(SECOND, [b"0.1"])
    assert state(device, SECOND) is State.SETTING_UP
    rates_told = device.step(SECOND + TICK_NS, [b"2\n0.1\n"]).readings
    assert len(rates_told) == 1
    assert state(device, SECOND + TICK_NS) is State.WELL
    for step in range(60):
        device.step(2 * SECOND + step * TICK_NS, [b"\xfe\x80\x00"])
    assert state(device, 2 * SECOND + 590 * MS) is State.GARBLED
    for step in range(60):
        device.step(3 * SECOND + step * TICK_NS, [b"\nnan\n"])
    assert state(device, 3 * SECOND + 590 * MS) is State.FAULTY
    device.step(4 * SECOND, [b"5\n"])
    device.step(4 * SECOND + TICK_NS, [b"5\n"])
    assert device.health(4 * SECOND + TICK_NS).level is Level.OK
    assert state(device, 4 * SECOND + 520 * MS) is State.SILENT


def test_a_word_where_the_number_should_be_is_told_with_the_keys_to_look_at() -> None:
    device = gyro(key="gz=")
    for step in range(1, 80):
        device.step(step * TICK_NS, [b"gy=1.0\r\n"])
    health = device.health(790 * MS)
    assert health.state is State.GARBLED
    assert "'gz='" in health.message
    assert health.counts["bad lines"] == 79


@mark.parametrize(
    ("settings", "told"),
    [
        ({"scale": 0.0}, "scale is 0.0"),
        ({"fastest_dps": 0.0}, "fastest_dps is 0.0: expected 1.0 to"),
        ({"lag_ms": -1.0}, "lag_ms is -1.0"),
        ({"baud": 300}, "baud is 300: expected 1200"),
        ({"column": 0}, "column is 0: expected 1"),
        ({"column": 2, "key": "gz="}, "column and key: give one of them"),
        ({"separator": ""}, "separator is empty"),
        ({"separator": "\n"}, "separator is '\\n'"),
        ({"key": " gz"}, "it has blanks around it"),
        ({"key": "gyroß"}, "expected up to 16 ASCII characters"),
    ],
)
def test_impossible_settings_are_told(settings: dict[str, Any], told: str) -> None:
    with raises(ValueError, match=escape(told)):
        GyroText.Settings(**settings)


def test_a_hundred_thousand_bytes_of_noise_give_no_rate_that_cannot_be() -> None:
    random, device, told = Random(1), gyro(fastest_dps=500.0), 0
    words = [b"12.5\n", b"-499\r\n", b"501\n", b"nan\n", b"1e5,2\n", b"\r", b"\xff\xff"]
    fed = now_ns = 0
    while fed < 100_000:
        word = random.choice(words) if random.random() < 0.7 else random.randbytes(random.randrange(1, 30))
        if random.random() < 0.2:
            word = bytearray(word)
            word[random.randrange(len(word))] ^= 1 << random.randrange(8)
        now_ns += random.randrange(1, 20 * MS)
        fed += len(word)
        for reading in device.step(now_ns, [bytes(word)]).readings:
            assert isinstance(reading, GyroReading)
            assert abs(reading.rate) <= radians(500.0)
            assert now_ns - 50 * MS <= reading.stamp_ns <= now_ns
            told += 1
        device.health(now_ns)
    assert told > 1000
