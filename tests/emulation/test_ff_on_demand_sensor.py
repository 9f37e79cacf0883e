from random import Random
from typing import Any

import pytest

from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.ff_on_demand import FfOnDemandOptions, FfOnDemandSensor
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

MS = 1_000_000
SECOND = 1000 * MS
SPEED = 343.0
BYTE_NS = 10 * SECOND // 9600
FAR = bytes.fromhex("FF07A1A7")


class Host:
    """A sensor on its line, and what the host hears of it."""

    def __init__(self, distance: float | None = 1.953, **options: Any) -> None:
        self.fired_ns: list[int] = []
        echoes = () if distance is None else (Echo(distance, 20.0, "wall"),)
        surroundings = Surroundings(lambda fire_ns: echoes, SPEED, ping=self.fired_ns.append)
        self.sensor = FfOnDemandSensor("front", surroundings, Random(1), FfOnDemandOptions(**options))
        self.line = SerialLine("line", self.sensor)
        self.line.switch_on(0)

    def ask(self, data: bytes, at_ns: int = SECOND, for_ns: int = SECOND) -> list[tuple[int, int]]:
        """Send, and take every byte of what follows with its time."""
        self.line.send((data,), at_ns)
        heard = []
        while (now_ns := self.line.next_event_ns()) <= at_ns + for_ns:
            heard += [(now_ns, byte) for chunk in self.line.take(now_ns) for byte in chunk]
        return heard

    def answer(self, data: bytes = b"\x55", at_ns: int = SECOND) -> bytes:
        return bytes(byte for _, byte in self.ask(data, at_ns))


def test_the_trigger_is_answered_by_a_frame_when_it_has_listened() -> None:
    host = Host()
    heard = host.ask(b"\x55")
    assert bytes(byte for _, byte in heard) == FAR
    assert host.fired_ns == [SECOND + BYTE_NS]
    assert [now_ns for now_ns, _ in heard] == [
        SECOND + BYTE_NS + 60 * MS + count * 10 * SECOND // 9600 for count in (1, 2, 3, 4)
    ]


@pytest.mark.parametrize("data", [b"", b"\x01", b"\xaa\xff"])
def test_other_bytes_are_not_answered(data: bytes) -> None:
    assert Host().answer(data) == b""


def test_an_aj_sr04m_is_triggered_by_01() -> None:
    assert Host(part="aj-sr04m").answer(b"\x55") == b""
    assert Host(part="aj-sr04m").answer(b"\x01") == FAR
    assert Host(part="aj-sr04m", trigger=0x55).answer(b"\x55") == FAR


def test_while_it_listens_it_takes_no_trigger() -> None:
    host = Host()
    assert host.answer(b"\x55" * 10) == FAR
    assert len(host.fired_ns) == 1
    assert host.answer(at_ns=3 * SECOND) == FAR


@pytest.mark.parametrize(
    ("distance", "golden"), [(None, "FF0000FF"), (6.1, "FF0000FF"), (0.224, "FF00E0DF"), (0.19, "FF00BEBD")]
)
def test_nothing_and_too_near_have_their_values(distance: float | None, golden: str) -> None:
    assert Host(distance).answer() == bytes.fromhex(golden)


def test_some_say_nothing_when_they_hear_nothing() -> None:
    assert Host(None, no_echo=-1).answer() == b""


def test_garbage_is_four_random_bytes() -> None:
    host = Host()
    host.sensor.fault("garbage", 0)
    garbage = host.answer()
    assert (len(garbage), garbage == FAR) == (4, False)


@pytest.mark.parametrize(("verb", "late_ns"), [("delayed", 200 * MS), ("slow", 240 * MS)])
def test_it_may_be_late(verb: str, late_ns: int) -> None:
    in_time, host = Host().ask(b"\x55"), Host()
    host.sensor.fault(verb, 0)
    assert host.ask(b"\x55") == [(now_ns + late_ns, byte) for now_ns, byte in in_time]


@pytest.mark.parametrize("verb", ["off", "unplug"])
def test_without_power_it_answers_nothing_until_the_fault_is_cleared(verb: str) -> None:
    host = Host()
    host.sensor.fault(verb, 0)
    assert host.answer() == b""
    host.sensor.clear(3 * SECOND)
    assert host.answer(at_ns=4 * SECOND) == FAR


def test_a_power_cut_ends_the_ping_under_way() -> None:
    host = Host()
    host.line.send((b"\x55",), SECOND)
    host.line.advance(SECOND + 10 * MS)
    host.sensor.fault("off", SECOND + 10 * MS, MS)
    assert host.answer(b"", SECOND + 20 * MS) == b""
    assert host.answer(at_ns=3 * SECOND) == FAR
