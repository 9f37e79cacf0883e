from itertools import pairwise
from random import Random
from typing import Any

import pytest

from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.maxbotix import MaxbotixOptions, MaxbotixSensor
from echogrid.emulation.devices.maxbotix_kinds import KINDS
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

MS = 1_000_000
SECOND = 1000 * MS
SPEED = 345.578
"""m/s, at which an inch there and back takes the 147 us of the data sheet."""


class Wall:
    """What is heard, and when it was asked for."""

    def __init__(self, distance: float | None) -> None:
        self.distance = distance
        self.fired_ns: list[int] = []

    def __call__(self, fire_ns: int) -> tuple[Echo, ...]:
        return () if self.distance is None else (Echo(self.distance, 20.0, "wall"),)


def line(
    model: str, distance: float | None = 1.016, **options: Any
) -> tuple[MaxbotixSensor, SerialLine, Wall]:
    wall = Wall(distance)
    surroundings = Surroundings(wall, SPEED, ping=wall.fired_ns.append)
    sensor = MaxbotixSensor("front", surroundings, Random(1), MaxbotixOptions(model, **options))
    serial = SerialLine("port", sensor)
    serial.switch_on(0)
    return sensor, serial, wall


def arrivals(serial: SerialLine, until_ns: int) -> list[tuple[int, int]]:
    """Every byte with the time at which it came."""
    heard: list[tuple[int, int]] = []
    while (now_ns := serial.next_event_ns()) <= until_ns:
        heard += [(now_ns, byte) for data in serial.take(now_ns) for byte in data]
    return heard


def lines(serial: SerialLine, until_ns: int = 2 * SECOND) -> list[bytes]:
    return [each + b"\r" for each in b"".join(serial.take(until_ns)).split(b"\r")[:-1]]


@pytest.mark.parametrize(
    ("model", "distance", "golden"),
    [
        ("MB1010", 1.016, b"R040\r"),
        ("MB1001", 0.2032, b"R008 P0\r"),
        ("MB1240", 1.0, b"R100\r"),
        ("MB1261", 1.0, b"R0100\r"),
        ("MB1013", 0.48, b"R0480\r"),
        ("MB1403", 0.48, b"R0480 \r"),
        ("MB7363", 2.257, b"R2257\r"),
    ],
)
def test_the_lines_are_those_of_the_data_sheets(model: str, distance: float, golden: bytes) -> None:
    assert lines(line(model, distance)[1])[-1] == golden


@pytest.mark.parametrize(
    ("model", "nothing", "least"),
    [
        ("MB1010", b"R255\r", b"R006\r"),
        ("MB1240", b"R765\r", b"R020\r"),
        ("MB1260", b"R1068\r", b"R0020\r"),
        ("MB7389", b"R5000\r", b"R0300\r"),
        ("MB7383", b"R9999\r", b"R0500\r"),
    ],
)
def test_nothing_is_the_largest_number_and_too_near_the_least(
    model: str, nothing: bytes, least: bytes
) -> None:
    assert lines(line(model, None)[1])[-1] == nothing
    assert lines(line(model, 12.0)[1])[-1] == nothing
    assert lines(line(model, 0.05)[1])[-1] == least


def test_the_number_for_nothing_is_configurable() -> None:
    assert lines(line("MB1040", None, no_echo=254)[1])[-1] == b"R254\r"


@pytest.mark.parametrize(("model", "cycle_ms", "sends_ms"), [("MB1010", 49, 44.3), ("MB7389", 148, 140)])
def test_each_cycle_begins_with_a_ping_and_ends_with_a_line(
    model: str, cycle_ms: int, sends_ms: float
) -> None:
    _, serial, wall = line(model)
    ends = [now_ns for now_ns, byte in arrivals(serial, 2 * SECOND) if byte == ord("\r")]
    length_ns = 10 * SECOND * len(KINDS[model].line(1, False)) // 9600
    assert {after - before for before, after in pairwise(wall.fired_ns)} == {cycle_ms * MS}
    assert ends[-1] - round(sends_ms * MS) - length_ns in wall.fired_ns


def test_an_hrxl_tells_its_name_between_65_and_160_ms_after_power_up() -> None:
    heard = arrivals(line("MB7386")[1], SECOND)
    text = [(now_ns, byte) for now_ns, byte in heard if now_ns <= 160 * MS]
    assert bytes(byte for _, byte in text) == (
        b"HRXL-MaxSonar-WR\rPN:MB7386\rCopyright 2011-2013\rMaxBotix Inc.\rRoHS 1.8b090  0713\rTempI\r"
    )
    assert text[0][0] > 65 * MS
    assert chr(heard[len(text)][1]) == "R"


def test_an_lv_says_nothing_before_it_is_booted_and_calibrated() -> None:
    _, serial, wall = line("MB1010")
    arrivals(serial, SECOND)
    assert 299 * MS <= wall.fired_ns[0] < 348 * MS


def test_the_flag_of_a_park_sonar_takes_10_s_to_come_and_5_s_to_go() -> None:
    _, serial, wall = line("MB1001", 1.0)
    assert {each[-3:] for each in lines(serial, 10 * SECOND)} == {b"P0\r"}
    assert lines(serial, 11 * SECOND)[-1].endswith(b" P1\r")
    wall.distance = None
    assert {each[-3:] for each in lines(serial, 15 * SECOND)} == {b"P1\r"}
    assert lines(serial, 17 * SECOND)[-1].endswith(b" P0\r")


def test_what_passes_by_raises_no_flag() -> None:
    _, serial, wall = line("MB1001", 1.0)
    lines(serial, 8 * SECOND)
    wall.distance = None
    lines(serial, 9 * SECOND)
    wall.distance = 1.0
    assert lines(serial, 17 * SECOND)[-1].endswith(b" P0\r")


def test_garbage_is_as_many_random_bytes() -> None:
    sensor, serial, _ = line("MB1010")
    sensor.fault("garbage", 0)
    garbage = b"".join(serial.take(2 * SECOND))
    assert len(garbage) % 5 == 0
    assert b"R040\r" not in garbage


def test_slow_is_five_times_the_cycle_and_delayed_200_ms_late() -> None:
    sensor, serial, wall = line("MB1010")
    sensor.fault("slow", 0)
    arrivals(serial, 2 * SECOND)
    assert {after - before for before, after in pairwise(wall.fired_ns)} == {245 * MS}
    first_ns = arrivals(line("MB1010")[1], SECOND)[0][0]
    sensor, serial, _ = line("MB1010")
    sensor.fault("delayed", 0)
    assert arrivals(serial, SECOND)[0][0] == first_ns + 200 * MS


def test_a_power_cut_makes_it_boot_anew() -> None:
    sensor, serial, _ = line("MB7386")
    lines(serial, SECOND)
    sensor.fault("off", SECOND, SECOND)
    assert lines(serial, 3 * SECOND)[0] == b"HRXL-MaxSonar-WR\r"


def test_an_unknown_model_is_told_with_those_which_there_are() -> None:
    with pytest.raises(ValueError, match=r"no model 'MB9' \(there are: MB1000, MB1001, MB1003"):
        MaxbotixOptions("MB9")
