from random import Random

import pytest
from hypothesis import given, settings
from hypothesis.strategies import binary, integers, lists
from minimalmodbus import _calculate_crc  # type: ignore[attr-defined]
from pymodbus.framer import FramerRTU

from echogrid.emulation.devices.modbus_slave import ModbusSlave, SlaveOptions, crc16, sealed

from .modbus_host import MS, Host

CHARACTER_NS = 10 * 1_000_000_000 // 9600


class Shelf(ModbusSlave):
    """Four registers from 0x0100 on; only the first can be written."""

    def __init__(self, **options: object) -> None:
        super().__init__("shelf", SlaveOptions(**options), Random(1))
        self.words = [0x07A1, 0xFFFF, 0, 1]

    def _word(self, register: int) -> int | None:
        return self.words[register - 0x0100] if 0x0100 <= register <= 0x0103 else None

    def _write(self, register: int, word: int, now_ns: int) -> int:
        if register != 0x0100:
            return 2
        self.words[0] = word
        return 0


@given(binary(max_size=300))
def test_the_checksum_is_that_of_two_other_libraries(data: bytes) -> None:
    assert crc16(data).to_bytes(2, "little") == FramerRTU.compute_CRC(data).to_bytes(2, "big")
    assert crc16(data).to_bytes(2, "little") == _calculate_crc(data)


@pytest.mark.parametrize(
    ("request_", "reply"),
    [
        ("01 03 01 00 00 01 85 F6", "01 03 02 07 A1 7B CC"),
        ("01 03 01 00 00 04", "01 03 08 07 A1 FF FF 00 00 00 01"),
        ("01 06 01 00 12 34", "01 06 01 00 12 34"),
        ("01 03 01 00 00 05", "01 83 02"),
        ("01 03 00 FF 00 01", "01 83 02"),
        ("01 06 01 01 00 00", "01 86 02"),
        ("01 03 01 00 00 00", "01 83 03"),
        ("01 03 01 00 00 7E", "01 83 03"),
        ("01 03 01 00 01", "01 83 03"),
        ("01 10 01 00 00 01 02 00 00", "01 90 01"),
        ("01 2B", "01 AB 01"),
    ],
)
def test_requests_are_obeyed_or_refused_by_their_codes(request_: str, reply: str) -> None:
    plain = bytes.fromhex(request_)
    frame = plain if sealed(plain[:-2]) == plain else sealed(plain)
    said = bytes.fromhex(reply)
    assert Host(Shelf()).say(frame) == (said if sealed(said[:-2]) == said else sealed(said))


def test_a_written_register_is_read_back() -> None:
    host = Host(Shelf())
    host.write(1, 0x0100, 0xABCD)
    assert host.read(1, 0x0100) == [0xABCD]


@pytest.mark.parametrize(
    "frame", ["02 03 01 00 00 01 85 C5", "01 03 01 00 00 01 85 F7", "01 03 01 00 00 01", "01", "F6"]
)
def test_a_frame_for_another_or_a_spoilt_one_is_not_answered(frame: str) -> None:
    assert Host(Shelf()).say(frame) == b""


def test_what_is_said_to_all_is_obeyed_in_silence() -> None:
    host = Host(Shelf())
    assert host.write(0, 0x0100, 0x1234) == b""
    assert host.read(1, 0x0100) == [0x1234]


def test_a_reply_begins_when_silence_has_closed_the_request_and_the_device_has_turned_round() -> None:
    host = Host(Shelf(turnaround_ns=2 * MS))
    start_ns = host.now_ns
    host.read(1, 0x0100)
    silence_ns = 7 * CHARACTER_NS // 2
    assert host.came_ns == pytest.approx(start_ns + (8 + 7) * CHARACTER_NS + silence_ns + 2 * MS, abs=20)


def test_from_19200_baud_up_the_silence_is_1_75_ms() -> None:
    host = Host(Shelf(baud=115_200, turnaround_ns=0))
    start_ns = host.now_ns
    host.read(1, 0x0100)
    assert host.came_ns == pytest.approx(start_ns + 15 * 86_805 + 1_750_000, abs=20)


def test_parity_and_stop_bits_make_bytes_longer() -> None:
    host = Host(Shelf(parity="even", stop_bits=2, turnaround_ns=0))
    start_ns = host.now_ns
    host.read(1, 0x0100)
    assert host.came_ns == pytest.approx(start_ns + 18.5 * 12 / 9600 * 1e9, abs=30)


@pytest.mark.parametrize(("pause_characters", "answers"), [(1, True), (2, True), (3, False)])
def test_a_pause_splits_a_frame_when_the_timer_that_every_byte_restarts_runs_out(
    pause_characters: int, answers: bool
) -> None:
    host = Host(Shelf())
    frame = bytes.fromhex("01 03 01 00 00 01 85 F6")
    host.line.send((frame[:5],), host.now_ns)
    host.wait((5 + pause_characters) * CHARACTER_NS)
    assert bool(host.say(frame[5:])) == answers


@pytest.mark.parametrize(("characters", "answers"), [(0.0, False), (3.4, False), (3.6, True)])
def test_a_request_too_close_behind_another_s_reply_is_lost(characters: float, answers: bool) -> None:
    host = Host(Shelf(), Shelf(address=2))
    host.line.send((bytes.fromhex("01 03 01 00 00 01 85 F6"),), host.now_ns)
    came = 0
    while came < 7:
        host.now_ns = host.line.next_event_ns()
        came += sum(map(len, host.line.take(host.now_ns)))
    host.now_ns += round(characters * CHARACTER_NS)
    assert bool(host.say(sealed(bytes.fromhex("02 03 01 00 00 01")))) == answers


def test_two_at_one_address_talk_over_each_other() -> None:
    host = Host(Shelf(), Shelf())
    reply = host.say("01 03 01 00 00 01 85 F6")
    assert len(reply) == 14
    assert sealed(reply[:5]) != reply[:7]


def test_in_a_storm_most_requests_are_refused_as_busy() -> None:
    shelf = Shelf()
    host = Host(shelf)
    shelf.fault("nack_storm", host.now_ns)
    said = [host.ask(1, 3, 1, 0, 0, 1) for _ in range(100)]
    assert 50 < said.count(bytes((0x83, 6))) < 90
    shelf.clear(host.now_ns)
    assert host.read(1, 0x0100) == [0x07A1]


def test_garbage_is_as_long_as_the_reply_and_has_another_checksum() -> None:
    shelf = Shelf()
    host = Host(shelf)
    shelf.fault("garbage", host.now_ns)
    reply = host.say("01 03 01 00 00 01 85 F6")
    assert len(reply) == 7
    assert sealed(reply[:-2]) != reply


def test_a_delayed_reply_is_late_by_200_ms() -> None:
    shelf = Shelf()
    host = Host(shelf)
    host.read(1, 0x0100)
    after_ns = host.came_ns - (host.now_ns - 100 * MS)
    shelf.fault("delayed", host.now_ns)
    start_ns = host.now_ns
    host.say("01 03 01 00 00 01 85 F6", 400 * MS)
    assert host.came_ns - start_ns == after_ns + 200 * MS


@pytest.mark.parametrize("verb", ["off", "unplug"])
def test_without_power_it_is_silent(verb: str) -> None:
    shelf, other = Shelf(), Shelf(address=2)
    host = Host(shelf, other)
    shelf.fault(verb, host.now_ns, 300 * MS)
    assert host.ask(1, 3, 1, 0, 0, 1) == b""
    assert host.read(2, 0x0100) == [0x07A1]
    host.wait(200 * MS)
    assert host.read(1, 0x0100) == [0x07A1]


def test_an_adapter_that_echoes_hands_back_the_request() -> None:
    request = bytes.fromhex("01 03 01 00 00 01 85 F6")
    assert Host(Shelf(echo=1)).say(request) == request + bytes.fromhex("01 03 02 07 A1 7B CC")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"address": 0}, "address 0"),
        ({"address": 248}, "address 248"),
        ({"parity": "x"}, "parity 'x'"),
    ],
)
def test_impossible_options_are_refused_by_name(options: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        SlaveOptions(**options)


@given(lists(binary(min_size=1, max_size=30), max_size=10), integers(4, 40))
@settings(max_examples=60)
def test_whatever_is_said_to_it_the_next_request_behind_a_silence_is_answered(
    noise: list[bytes], characters: int
) -> None:
    host = Host(Shelf())
    for data in noise:
        host.say(data, (len(data) + characters) * CHARACTER_NS)
    host.wait(200 * MS)
    assert len(host.say("01 03 01 01 00 01 D4 36")) == 7
