"""The emulated controller by the maker's examples, and read by the maker's own library."""

from itertools import pairwise
from math import isnan, tau
from random import Random
from struct import unpack
from typing import Any

import pytest

from echogrid.drivers.bus import CanFrame
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.moteus import (
    Moteus,
    MoteusOptions,
    milliseconds,
    reads,
    scaled,
    varuint,
    whole,
)

MS = 1_000_000
SECOND = 1000 * MS
NODE = 9
TURNS_PER_S = 2.0
READY_NS = 400 * MS
ALL = bytes.fromhex("11001E01130D115819705050")
"""Mode, position and velocity, supply, temperature and fault, validity, milliseconds."""


def controller(**options: Any) -> Moteus:
    def angle(now_ns: int) -> float:
        return (0.2 + TURNS_PER_S * now_ns / SECOND) * tau

    return Moteus("wheel", angle, Random(1), MoteusOptions(**{"node": NODE, **options}))


class Host:
    """Asks a controller on a bus."""

    def __init__(self, node: Moteus) -> None:
        self.node = node
        self.bus = CanBus("can", 1_000_000, [node])
        self.bus.switch_on(0)
        self.now_ns = READY_NS

    def ask(self, data: bytes, identifier: int = 0x8000 | NODE, *, fd: bool = True) -> tuple[CanFrame, ...]:
        """What has come 5 ms later."""
        self.bus.send((CanFrame(identifier, data, extended=True, fd=fd),), self.now_ns)
        self.now_ns += 5 * MS
        return self.bus.take(self.now_ns)

    def answer(self, data: str) -> bytes:
        (frame,) = self.ask(bytes.fromhex(data))
        return frame.data

    def position(self) -> float:
        (turns,) = unpack("<f", self.answer("1D01")[2:6])
        return float(turns)


def test_values_are_scaled_as_in_the_makers_example() -> None:
    assert whole(10, 1) == bytes.fromhex("0A00")
    assert scaled(2.88 / 360, 1, (0.01, 0.0001, 0.00001)) == bytes.fromhex("5000")
    assert scaled(23.04 / 360, 1, (0.1, 0.00025, 0.00001)) == bytes.fromhex("0001")
    assert scaled(-1.44, 1, (0.5, 0.01, 0.001)) == bytes.fromhex("70FF")
    assert scaled(12.0, 0, (0.5, 0.1, 0.001)) + scaled(20.0, 0, (1.0, 0.1, 0.001)) == b"\x18\x14"


def test_the_makers_example_is_understood() -> None:
    command = bytes.fromhex("01000A07206000200150FF140400130D")
    assert reads(command) == [(1, 0, 4), (0, 0x0D, 3)]
    (frame,) = Host(controller()).ask(command)
    assert (frame.data[:3], frame.data[11:13], len(frame.data)) == (b"\x24\x04\x00", b"\x23\x0d", 16)


def test_a_reply_comes_from_its_identifier_by_can_fd_padded() -> None:
    (frame,) = Host(controller()).ask(ALL)
    assert (frame.identifier, frame.extended, frame.fd, len(frame.data)) == (NODE << 8, True, True, 32)
    assert frame.data[27:] == b"\x50" * 5
    (short,) = Host(controller(node=1)).ask(ALL, 0x8001)
    assert (short.identifier, short.extended) == (0x100, False)


def test_prefix_and_source_come_back() -> None:
    host = Host(controller(prefix=0x15))
    assert host.ask(ALL) == ()
    (frame,) = host.ask(ALL, 0x15_8509)
    assert frame.identifier == 0x15_0905


@pytest.mark.parametrize(
    ("identifier", "fd"), [(NODE, True), (0x8008, True), (0x8000 | NODE, False), (0x8089, True)]
)
def test_who_is_not_asked_says_nothing(identifier: int, fd: bool) -> None:
    assert Host(controller()).ask(ALL, identifier, fd=fd) == ()


def test_the_position_begins_within_half_a_turn_and_goes_on() -> None:
    host = Host(controller())
    first_ns, first = host.now_ns, host.position()
    assert first == pytest.approx(0.0, abs=0.01)  # at 0.3 s it began with -0.2
    host.now_ns = 10 * SECOND
    assert host.position() - first == pytest.approx(TURNS_PER_S * (10 * SECOND - first_ns) / SECOND, abs=1e-4)


def test_turns_that_it_has_made_already_are_told() -> None:
    assert Host(controller(origin=1000.0, gear=-1.0)).position() == pytest.approx(1000.0, abs=0.01)


def test_integers_end_where_they_must() -> None:
    host = Host(controller(origin=30_000.0))
    assert host.answer("1501")[2:4] == bytes.fromhex("FF7F")
    assert host.answer("1901")[2:6] == bytes.fromhex("FFFFFF7F")
    host.node.fault("encoder_lost", host.now_ns)
    assert host.answer("1901")[2:6] == bytes.fromhex("00000080")
    assert isnan(host.position())


def test_its_milliseconds_wrap_at_the_end_of_their_form() -> None:
    assert milliseconds(127, 0) + milliseconds(128, 0) == b"\x7f\x80"
    assert milliseconds(1 << 31, 2) == bytes.fromhex("00000080")
    assert milliseconds(8_388_609, 3) == milliseconds(1, 3)


def test_an_unknown_register_is_an_error() -> None:
    answer = Host(controller()).answer("11 0F 11 A0 02 13 0E")
    assert answer == bytes.fromhex("210F00 31A00201 311001 5050")
    assert Host(controller(counts_milliseconds=0)).answer("1970") == bytes.fromhex("317001")


def test_what_is_too_long_for_a_frame_is_left_out() -> None:
    (frame,) = Host(controller()).ask(b"\x1e\x01" * 10)
    assert (len(frame.data), frame.data[50:52]) == (64, b"\x2e\x01")


@pytest.mark.parametrize(
    "data", [b"\x10", b"\x11", b"\x10\xff\xff\xff\xff\x0f\x00", b"\xff", b"\x0d\x00\x01"]
)
def test_a_request_that_is_cut_short_is_answered_as_far_as_it_goes(data: bytes) -> None:
    assert all(len(frame.data) <= 64 for frame in Host(controller()).ask(data))


def test_varuints_have_seven_bits_to_a_byte() -> None:
    assert [varuint(number) for number in (0, 127, 128, 0x120)] == [b"\0", b"\x7f", b"\x80\x01", b"\xa0\x02"]


def test_faults_are_told_by_mode_code_heat_and_validity() -> None:
    host = Host(controller())
    assert host.answer("11 00 13 0D 11 58") == bytes.fromhex("210000 230D302300 215803 50")
    host.node.fault("motor_failed", host.now_ns, 5 * MS)
    assert host.answer("11 00 11 0F") == bytes.fromhex("210001 210F21")
    host.node.fault("encoder_lost", host.now_ns, 5 * MS)
    assert host.answer("11 00 11 0F 11 58") == bytes.fromhex("210001 210F23 215800 505050")
    host.node.fault("overheated", host.now_ns, 5 * MS)
    assert host.answer("11 0E") == bytes.fromhex("210E48")
    host.now_ns += 10 * MS
    assert host.answer("11 00 11 0F") == bytes.fromhex("210000 210F00")


@pytest.mark.parametrize("verb", ["off", "unplug"])
def test_without_power_it_is_silent_and_begins_anew(verb: str) -> None:
    host = Host(controller())
    host.now_ns = 3 * SECOND
    assert host.position() > 5.0
    host.node.fault(verb, host.now_ns, SECOND)
    assert host.ask(ALL) == ()
    host.now_ns = 4 * SECOND + 200 * MS
    assert host.ask(ALL) == ()
    host.now_ns = 4 * SECOND + 310 * MS
    assert abs(host.position()) < 0.6


def test_garbage_has_the_length_of_a_reply_and_its_identifier() -> None:
    host = Host(controller())
    host.node.fault("garbage", host.now_ns)
    frames = [host.ask(ALL)[0] for _ in range(20)]
    assert {(frame.identifier, len(frame.data)) for frame in frames} == {(NODE << 8, 32)}
    assert len({frame.data for frame in frames}) == 20


def test_delayed_is_late_by_200_ms() -> None:
    host = Host(controller())
    host.node.fault("delayed", host.now_ns)
    assert host.ask(ALL) == ()
    (frame,) = host.bus.take(READY_NS + 210 * MS)
    assert READY_NS + 200 * MS < frame.stamp_ns < READY_NS + 201 * MS


def test_commands_are_not_obeyed() -> None:
    host = Host(controller())
    host.ask(bytes.fromhex("01000A0D20000080BF"), NODE)
    first, second = host.position(), host.position()
    assert second - first == pytest.approx(TURNS_PER_S * 0.005, abs=1e-4)
    assert host.answer("1100") == bytes.fromhex("210000")


def test_the_makers_library_reads_it() -> None:
    maker = pytest.importorskip("moteus", reason="the maker's library is not installed (pip install moteus)")
    resolution = maker.QueryResolution()
    resolution._extra = {0x058: maker.INT8, 0x070: maker.INT32}
    host = Host(controller())
    for form in (maker.INT16, maker.INT32, maker.F32):
        resolution.position = resolution.velocity = resolution.voltage = form
        command = maker.Controller(id=NODE, query_resolution=resolution).make_query()
        asked_ns = host.now_ns
        (frame,) = host.ask(command.data)
        told = maker.protocol.parse_reply(frame.data)
        assert told[1] == pytest.approx(0.2 + TURNS_PER_S * asked_ns / SECOND - 1.0, abs=2e-3)
        assert told[2] == pytest.approx(TURNS_PER_S, abs=1e-3)
        assert (told[0], told[0x0D], told[0x0E], told[0x0F]) == (0, 24.0, 35, 0)
        assert (told[0x58], told[0x70]) == (3, pytest.approx(asked_ns // MS - 300, abs=1))


@pytest.mark.parametrize("seed", range(50))
def test_the_makers_library_reads_whatever_is_asked(seed: int) -> None:
    maker = pytest.importorskip("moteus", reason="the maker's library is not installed (pip install moteus)")
    random = Random(seed)
    fields = {
        random.choice((0, 1, 2, 3, 0x0D, 0x0E, 0x0F, 0x58, 0x70, 0x71)): random.choice(
            (maker.INT16, maker.INT32, maker.F32)
        )
        for _ in range(3)
    }
    command = maker.Controller(id=NODE).make_custom_query(fields)
    (frame,) = Host(controller()).ask(command.data)
    told = maker.protocol.parse_registers(frame.data)
    assert set(told.response) == fields.keys() - {0x71}
    assert {register for register, _ in told.errors} == fields.keys() & {0x71}


def test_answers_go_in_the_order_of_their_requests() -> None:
    host = Host(controller())
    stamps = [host.ask(ALL)[0].stamp_ns for _ in range(5)]
    assert all(sooner < later for sooner, later in pairwise(stamps))


@pytest.mark.parametrize(
    ("options", "text"),
    [({"node": 0}, "node 0"), ({"node": 128}, "node 128"), ({"prefix": -1}, "prefix -0x1")],
)
def test_impossible_options_are_refused(options: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        controller(**options)
