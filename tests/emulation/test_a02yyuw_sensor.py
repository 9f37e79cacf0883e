from itertools import pairwise
from random import Random
from typing import Any

import pytest

from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.a02yyuw import A02yyuwOptions, A02yyuwSensor
from echogrid.emulation.devices.ff_parts import FF_PARTS, frame
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

MS = 1_000_000
SECOND = 1000 * MS
SPEED = 343.0


def line(distance: float | None = 1.953, seed: int = 1, **options: Any) -> tuple[A02yyuwSensor, SerialLine]:
    echoes = () if distance is None else (Echo(distance, 20.0, "wall"),)
    surroundings = Surroundings(lambda fire_ns: echoes, SPEED)
    sensor = A02yyuwSensor("left", surroundings, Random(seed), A02yyuwOptions(**options))
    serial = SerialLine("port", sensor)
    serial.switch_on(0)
    return sensor, serial


def arrivals(serial: SerialLine, until_ns: int) -> list[tuple[int, int]]:
    """Every byte with the time at which it came."""
    heard: list[tuple[int, int]] = []
    while (now_ns := serial.next_event_ns()) <= until_ns:
        heard += [(now_ns, byte) for data in serial.take(now_ns) for byte in data]
    return heard


def sent(serial: SerialLine, until_ns: int) -> bytes:
    return b"".join(serial.take(until_ns))


@pytest.mark.parametrize(
    ("millimetres", "golden"), [(1953, "FF07A1A7"), (1717, "FF06B5BA"), (224, "FF00E0DF"), (0, "FF0000FF")]
)
def test_frames_are_those_of_real_sensors(millimetres: int, golden: str) -> None:
    assert frame(millimetres) == bytes.fromhex(golden)


def test_a_wall_is_sent_every_100_ms() -> None:
    _, serial = line()
    heard = arrivals(serial, SECOND)
    assert bytes(byte for _, byte in heard) == bytes.fromhex("FF07A1A7") * (len(heard) // 4)
    starts = [now_ns for now_ns, _ in heard[::4]]
    assert {later - sooner for sooner, later in pairwise(starts)} == {100 * MS}


def test_a_frame_ends_lag_and_four_bytes_after_the_echo_came() -> None:
    fired: list[int] = []

    def scene(fire_ns: int) -> tuple[Echo, ...]:
        fired.append(fire_ns)
        return (Echo(1.0, 9.0, "wall"),)

    options = A02yyuwOptions(lag_ns=50 * MS)
    serial = SerialLine("port", A02yyuwSensor("left", Surroundings(scene, SPEED), Random(1), options))
    serial.switch_on(0)
    ends = [now_ns for now_ns, _ in arrivals(serial, SECOND)]
    start_ns = fired[0] + round(2 / SPEED * 1e9) + 50 * MS
    assert ends[:4] == [start_ns + count * 10 * SECOND // 9600 for count in (1, 2, 3, 4)]


def test_two_sensors_fire_in_phases_of_their_own() -> None:
    first = arrivals(line(seed=1)[1], SECOND)[0][0]
    second = arrivals(line(seed=2)[1], SECOND)[0][0]
    assert first != second


@pytest.mark.parametrize("distance", [None, 4.6])
def test_nothing_within_reach_is_the_value_0(distance: float | None) -> None:
    assert sent(line(distance)[1], 400 * MS)[:4] == bytes.fromhex("FF0000FF")


def test_the_value_for_nothing_is_configurable() -> None:
    assert sent(line(None, no_echo=0xFFFD)[1], 400 * MS)[:4] == bytes.fromhex("FFFFFDFB")
    assert sent(line(None, no_echo=-1)[1], SECOND) == b""


@pytest.mark.parametrize(("distance", "golden"), [(0.029, "FF001D1C"), (0.0, "FF000100")])
def test_too_near_is_a_value_below_the_minimum_but_not_0(distance: float, golden: str) -> None:
    assert sent(line(distance)[1], 400 * MS)[:4] == bytes.fromhex(golden)


def test_some_boards_leave_the_header_out_of_the_sum() -> None:
    assert sent(line(0.222, header_summed=False)[1], 400 * MS)[:4] == bytes.fromhex("FF00DEDE")


@pytest.mark.parametrize("part", FF_PARTS)
def test_each_part_has_its_reach_and_its_value_for_nothing(part: str) -> None:
    reach = FF_PARTS[part].reach
    assert sent(line(reach - 0.01, part=part)[1], 400 * MS)[:4] == frame(round(reach * 1000) - 10)
    assert sent(line(reach + 0.01, part=part)[1], 400 * MS)[:4] == frame(FF_PARTS[part].no_echo)


def test_an_unknown_part_is_told_with_those_which_there_are() -> None:
    with pytest.raises(ValueError, match=r"no part 'a03' \(there are: a02yyuw, a01nyub, "):
        A02yyuwOptions(part="a03")


def test_an_echo_below_the_threshold_is_not_heard() -> None:
    surroundings = Surroundings(lambda fire_ns: (Echo(1.0, -0.1, "edge"), Echo(2.0, 3.0, "wall")), SPEED)
    serial = SerialLine("port", A02yyuwSensor("left", surroundings, Random(1)))
    serial.switch_on(0)
    assert sent(serial, 400 * MS)[:4] == frame(2000)


def test_off_is_silent_for_its_time() -> None:
    sensor, serial = line()
    sent(serial, SECOND)
    serial.advance(SECOND)
    sensor.fault("off", SECOND, SECOND)
    times = [now_ns for now_ns, _ in arrivals(serial, 3 * SECOND)]
    assert times[0] > 2 * SECOND
    assert sensor.faults.active() == ()


def test_garbage_is_random_bytes() -> None:
    sensor, serial = line()
    sensor.fault("garbage", 0)
    garbage = sent(serial, SECOND)
    assert len(garbage) >= 32
    assert frame(1953) not in garbage


def test_delayed_is_late_by_200_ms() -> None:
    first_ns = arrivals(line()[1], SECOND)[0][0]
    sensor, serial = line()
    sensor.fault("delayed", 0)
    assert arrivals(serial, SECOND)[0][0] == first_ns + 200 * MS


def test_unplug_takes_the_port_away() -> None:
    sensor, serial = line()
    sensor.fault("unplug", 0, SECOND)
    assert not serial.present
    assert arrivals(serial, 3 * SECOND)[0][0] > SECOND
    assert serial.present
    assert serial.unplugs == 1
