import struct
from collections.abc import Iterable
from itertools import pairwise
from math import tau
from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers.bus import CanFrame
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.canopen_objects import Dictionary, Item
from echogrid.emulation.devices.cia402 import Cia402Drive, Cia402Options
from echogrid.emulation.devices.shaft import MotorShaft

MS = 1_000_000
SECOND = 1000 * MS
NODE = 2
TURNS_PER_S = 0.5
BOOT_NS = 200 * MS


def turning(now_ns: int) -> float:
    return 7.0 + TURNS_PER_S * tau * now_ns / SECOND


class Host:
    """Somebody with an adapter, who speaks to one drive."""

    def __init__(self, angle: Any = turning, **options: Any) -> None:
        self.drive = Cia402Drive("wheel", angle, Random(1), Cia402Options(**{"node": NODE, **options}))
        self.bus = CanBus("can", 500_000, [self.drive])
        self.bus.switch_on(0)
        self.now_ns = 0

    def wait(self, milliseconds: int) -> list[CanFrame]:
        """What comes meanwhile."""
        self.now_ns += milliseconds * MS
        return list(self.bus.take(self.now_ns))

    def send(self, identifier: int, data: str, milliseconds: int = 5) -> list[CanFrame]:
        """Send bytes in hex; what comes then."""
        self.bus.send([CanFrame(identifier, bytes.fromhex(data))], self.now_ns)
        return self.wait(milliseconds)

    def ask(self, data: str) -> str:
        """The reply to an SDO request, in hex."""
        (reply,) = of(0x580 + NODE, self.send(0x600 + NODE, data))
        return reply.data.hex()

    def read(self, index: int, sub: int = 0) -> bytes:
        """The four bytes of an object."""
        return bytes.fromhex(self.ask(f"40{index.to_bytes(2, 'little').hex()}{sub:02x}00000000"))[4:]

    def write(self, index: int, sub: int, value: int, length: int) -> str:
        """ "" or the abort code in hex."""
        command = {1: "2f", 2: "2b", 4: "23"}[length]
        data = value.to_bytes(length, "little", signed=value < 0).ljust(4, b"\0").hex()
        reply = self.ask(f"{command}{index.to_bytes(2, 'little').hex()}{sub:02x}{data}")
        return "" if reply.startswith("60") else f"{int.from_bytes(bytes.fromhex(reply)[4:], 'little'):08x}"

    def start(self) -> list[CanFrame]:
        """Make it operational."""
        return self.send(0x000, f"01{NODE:02x}")

    def motion_pdo(self) -> None:
        """Have its first TPDO hold position and velocity, each 20 ms."""
        assert self.write(0x1800, 1, 0x80000182, 4) == ""
        assert self.write(0x1800, 5, 20, 2) == ""
        assert self.write(0x1A00, 0, 0, 1) == ""
        assert self.write(0x1A00, 1, 0x60640020, 4) == ""
        assert self.write(0x1A00, 2, 0x606C0020, 4) == ""
        assert self.write(0x1A00, 0, 2, 1) == ""
        assert self.write(0x1800, 1, 0x182, 4) == ""


def of(identifier: int, frames: Iterable[CanFrame]) -> list[CanFrame]:
    return [frame for frame in frames if frame.identifier == identifier]


def signed(data: bytes) -> int:
    return int.from_bytes(data, "little", signed=True)


def booted(angle: Any = turning, **options: Any) -> Host:
    host = Host(angle, **options)
    host.wait(250)
    return host


def test_it_says_that_it_has_booted_and_then_nothing() -> None:
    frames = Host().wait(3000)
    assert [(frame.identifier, frame.data) for frame in frames] == [(0x702, b"\0")]
    assert frames[0].stamp_ns == pytest.approx(BOOT_NS, abs=MS)


def test_the_known_request_has_the_known_reply() -> None:
    host = booted(lambda _: 0.0, origin=-123456)
    assert host.ask("4064600000000000") == "43646000c01dfeff"


@pytest.mark.parametrize(
    ("request_data", "reply"),
    [
        ("4000100000000000", "4300100092010200"),
        ("4041600000000000", "4b41600050020000"),
        ("4061600000000000", "4f61600000000000"),
        ("4034120000000000", "8034120000000206"),
        ("4018100900000000", "8018100911000906"),
        ("2f00100001000000", "8000100002000106"),
        ("2f17100001000000", "8017100013000706"),
        ("2317100001000000", "8017100012000706"),
        ("2b17100064000000", "6017100000000000"),
        ("2217100064000000", "6017100000000000"),
        ("2f60600009000000", "8060600030000906"),
        ("2117100008000000", "8017100001000405"),
        ("a000100000000000", "8000100001000405"),
    ],
)
def test_objects_are_served_or_refused_as_the_standard_says(request_data: str, reply: str) -> None:
    assert booted().ask(request_data) == reply


def test_an_abort_of_the_client_s_has_no_reply() -> None:
    assert booted().send(0x602, "8017100000000405") == []


@given(st.binary(min_size=8, max_size=8))
def test_any_request_has_one_reply_of_eight_bytes_or_none(request_data: bytes) -> None:
    dictionary = Dictionary()
    dictionary.add({(0x1000, 0): Item("I"), (0x1001, 0): Item("B"), (0x1017, 0): Item("H")})
    reply = dictionary.serve(request_data, 0)
    assert (reply is None) == (request_data[0] >> 5 == 4)
    assert reply is None or (len(reply) == 8 and reply[1:4] == request_data[1:4])


def test_the_heartbeat_has_its_period_and_tells_the_state() -> None:
    host = booted()
    host.write(0x1017, 0, 100, 2)
    beats = of(0x702, host.wait(1000))
    assert {frame.data for frame in beats} == {b"\x7f"}
    assert {later.stamp_ns - sooner.stamp_ns for sooner, later in pairwise(beats)} == {100 * MS}
    host.start()
    assert {frame.data for frame in of(0x702, host.wait(500))} == {b"\x05"}
    host.send(0x000, "0200")
    assert {frame.data for frame in of(0x702, host.wait(500))} == {b"\x04"}
    assert host.send(0x602, "4000100000000000") == []
    host.send(0x000, "8002")
    assert {frame.data for frame in of(0x702, host.wait(500))} == {b"\x7f"}


def test_a_reset_forgets_its_settings_and_boots_again() -> None:
    host = booted()
    host.write(0x1017, 0, 100, 2)
    host.start()
    frames = host.send(0x000, "8102", 1000)
    assert [frame.data for frame in of(0x702, frames)] == [b"\0"]


def test_a_command_to_another_node_is_not_obeyed() -> None:
    host = booted()
    host.send(0x000, "0103")
    assert host.wait(500) == []


def test_position_and_velocity_come_by_the_event_timer_once_it_is_operational() -> None:
    host = booted(gear=2.0, counts_per_turn=1000)
    host.motion_pdo()
    assert host.wait(200) == []
    host.start()
    frames = of(0x182, host.wait(1000))
    assert len(frames) in (49, 50, 51)
    position, velocity = struct.unpack("<ii", frames[-1].data)
    assert velocity == pytest.approx(1000, abs=2)
    seconds = (frames[-1].stamp_ns) / SECOND
    assert position == pytest.approx(1000 * seconds, abs=2)


def test_the_known_pdo_is_sent() -> None:
    host = booted(lambda _: 0.0, origin=-123456)
    host.motion_pdo()
    host.start()
    assert of(0x182, host.wait(100))[0].data.hex() == "c01dfeff00000000"


def test_a_pdo_of_type_n_is_sent_at_every_nth_sync() -> None:
    host = booted()
    host.motion_pdo()
    host.write(0x1800, 2, 2, 1)
    host.start()
    assert of(0x182, host.wait(500)) == []
    sent = [len(of(0x182, host.send(0x080, ""))) for _ in range(6)]
    assert sent == [0, 1, 0, 1, 0, 1]


def test_a_pdo_by_event_is_sent_when_its_object_changes_but_not_within_its_inhibit_time() -> None:
    host = booted()
    host.write(0x1800, 1, 0x80000182, 4)
    host.write(0x1800, 3, 1000, 2)
    host.write(0x1800, 1, 0x182, 4)
    host.start()
    host.wait(300)
    first = of(0x182, host.send(0x202, "0600"))
    second = of(0x182, host.send(0x202, "0700")) + of(0x182, host.wait(200))
    assert [frame.data.hex() for frame in (*first, *second)] == ["3102", "3302"]
    assert second[0].stamp_ns - first[0].stamp_ns == pytest.approx(100 * MS, abs=MS)


@pytest.mark.parametrize(
    ("key", "value", "length", "abort"),
    [
        ((0x1A00, 0), 0, 1, "06010000"),
        ((0x1A00, 1), 0x60640020, 4, "06010000"),
        ((0x1800, 1), 0x183, 4, "06090030"),
        ((0x1800, 2), 250, 1, "06090030"),
        ((0x1800, 3), 10, 2, "06010000"),
    ],
)
def test_a_pdo_that_is_on_is_not_changed(key: tuple[int, int], value: int, length: int, abort: str) -> None:
    assert booted().write(*key, value, length) == abort


def test_a_mapping_must_be_of_objects_that_fit() -> None:
    host = booted()
    host.write(0x1800, 1, 0x80000182, 4)
    assert host.write(0x1A00, 1, 0x60640020, 4) == "06010000"
    host.write(0x1A00, 0, 0, 1)
    assert host.write(0x1A00, 1, 0x60640010, 4) == "06040041"
    assert host.write(0x1A00, 1, 0x10000020, 4) == "06040041"
    assert host.write(0x1A00, 1, 0x12340020, 4) == "06020000"
    for sub, entry in enumerate((0x60640020, 0x606C0020, 0x60410010), 1):
        assert host.write(0x1A00, sub, entry, 4) == ""
    assert host.write(0x1A00, 0, 3, 1) == "06040042"
    assert host.write(0x1A00, 0, 4, 1) == "06040041"
    assert host.write(0x1A00, 0, 9, 1) == "06090030"


@pytest.mark.parametrize(("origin", "direction"), [((1 << 31) - 1000, 1.0), (1000 - (1 << 31), -1.0)])
def test_the_position_wraps_at_its_32_bits(origin: int, direction: float) -> None:
    host = booted(lambda now_ns: direction * turning(now_ns), origin=origin)
    before = signed(host.read(0x6064))
    host.wait(500)
    after = signed(host.read(0x6064))
    assert before * after < 0
    assert (after - before) % (1 << 32) == pytest.approx(direction * 1044 % (1 << 32), abs=60)


def test_the_position_wraps_within_its_range() -> None:
    host = booted(range_counts=1000)
    positions = [signed(host.read(0x6064)) for _ in range(400)]
    assert -500 <= min(positions) < -400 and 400 < max(positions) < 500


def enabled(host: Host) -> list[str]:
    """Lead it to operation enabled, in profile velocity mode; the status words on the way."""
    host.start()
    host.write(0x6060, 0, 3, 1)
    told = []
    for word in (0x06, 0x07, 0x0F):
        host.send(0x202, word.to_bytes(2, "little").hex())
        told.append(host.read(0x6041)[:2].hex())
    return told


def test_control_words_lead_from_state_to_state() -> None:
    host = booted()
    assert host.read(0x6041)[:2].hex() == "5002"
    assert enabled(host) == ["3102", "3302", "3702"]
    host.send(0x202, "0600")
    assert host.read(0x6041)[:2].hex() == "3102"
    host.send(0x202, "0000")
    assert host.read(0x6041)[:2].hex() == "5002"


def test_a_state_is_not_skipped() -> None:
    host = booted()
    host.start()
    host.send(0x202, "0f00")
    assert host.read(0x6041)[:2].hex() == "5002"


def test_its_motor_turns_at_the_target_when_it_is_enabled_only() -> None:
    shaft = MotorShaft()
    host = booted(shaft, gear=-2.0, counts_per_turn=1000)
    host.write(0x60FF, 0, 4000, 4)
    host.wait(500)
    assert shaft.rate(host.now_ns) == 0.0
    enabled(host)
    host.wait(1000)
    assert shaft.rate(host.now_ns) == pytest.approx(-2 * tau)
    host.send(0x202, "0200")
    assert host.read(0x6041)[:2].hex() == "1702"
    host.wait(600)
    assert host.read(0x6041)[:2].hex() == "5002"
    assert shaft.rate(host.now_ns) == 0.0


def test_a_pdo_that_is_too_short_is_told() -> None:
    host = booted()
    host.start()
    assert of(0x082, host.send(0x502, "0600"))[0].data[:2].hex() == "1082"
    assert host.read(0x6041)[:2].hex() == "5002"


def test_without_its_master_it_stops_if_it_is_told_to() -> None:
    shaft = MotorShaft()
    host = booted(shaft)
    host.write(0x60FF, 0, 4096, 4)
    assert host.write(0x1016, 1, 127 << 16 | 500, 4) == ""
    assert host.write(0x6007, 0, 3, 2) == ""
    enabled(host)
    assert of(0x082, host.wait(1000)) == []
    host.send(0x77F, "05")
    assert of(0x082, host.wait(480)) == []
    assert [frame.data[:3].hex() for frame in of(0x082, host.wait(50))] == ["308111"]
    host.wait(600)
    assert shaft.rate(host.now_ns) == 0.0
    assert [frame.data[:3].hex() for frame in of(0x082, host.send(0x77F, "05"))] == ["000000"]


def test_a_tripped_drive_is_in_fault_until_its_cause_is_gone_and_it_is_reset() -> None:
    shaft = MotorShaft()
    host = booted(shaft)
    host.write(0x60FF, 0, 4096, 4)
    enabled(host)
    host.wait(500)
    host.drive.fault("tripped", host.now_ns, SECOND)
    assert [frame.data[:3].hex() for frame in of(0x082, host.wait(10))] == ["102303"]
    assert host.read(0x1001)[0] == 0x03
    host.send(0x202, "8000")
    assert host.read(0x6041)[:2].hex() == "1802"
    assert [frame.data[:3].hex() for frame in of(0x082, host.wait(1000))] == ["000000"]
    assert host.read(0x6041)[:2].hex() == "5002"
    assert shaft.rate(host.now_ns) == 0.0


def test_a_lost_encoder_stands_and_then_counts_anew() -> None:
    host = booted()
    host.drive.fault("encoder_lost", host.now_ns, SECOND)
    assert [frame.data[:2].hex() for frame in of(0x082, host.wait(10))] == ["0573"]
    before = host.read(0x6064)
    host.wait(500)
    assert host.read(0x6064) == before and signed(host.read(0x606C)) == 0
    host.wait(600)
    assert 0 <= signed(host.read(0x6064)) < 1000


@pytest.mark.parametrize("verb", ["off", "reset"])
def test_a_restart_begins_at_zero_with_a_boot_up_message(verb: str) -> None:
    host = booted()
    host.wait(3000)
    host.drive.fault(verb, host.now_ns, 100 * MS)
    assert [frame.data for frame in of(0x702, host.wait(500))] == [b"\0"]
    assert signed(host.read(0x6064)) < 1500


@pytest.mark.parametrize("wrong", [{"node": 0}, {"node": 128}, {"counts_per_turn": 0.0}])
def test_impossible_options_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Cia402Options(**wrong)
