from random import Random

import pytest

from echogrid.emulation.devices.srf02_serial import Srf02SerialOptions, Srf02SerialSensor

from .line_host import MS, SPEED, Host, room

BYTE_NS = 11 * 1_000_000_000 // 9600
RANGING_NS = 65 * MS


def sensor(*distances: float, name: str = "front", **options: float) -> Srf02SerialSensor:
    chosen = Srf02SerialOptions(**{"first_minimum": 0.15, **options})  # type: ignore[arg-type]
    return Srf02SerialSensor(name, room(*distances), Random(1), chosen)


def ranged(host: Host, command: int = 0x51, address: int = 0) -> bytes:
    host.ask(bytes((address, command)), within_ns=70 * MS)
    return host.ask(bytes((address, 0x5E)))


def test_a_wall_at_three_metres_reads_as_01_2c_centimetres() -> None:
    assert ranged(Host(sensor(3.0))) == bytes.fromhex("012C")


@pytest.mark.parametrize(("command", "value"), [(0x50, 118), (0x51, 300), (0x52, 17493)])
def test_each_ranging_command_has_its_unit(command: int, value: int) -> None:
    assert int.from_bytes(ranged(Host(sensor(3.0)), command), "big") == value


def test_a_byte_has_two_stop_bits() -> None:
    host = Host(sensor(3.0))
    host.ask(b"\x00\x5e")
    assert host.came_ns == pytest.approx([3 * BYTE_NS, 4 * BYTE_NS], abs=3)


def test_nothing_heard_is_zero() -> None:
    assert ranged(Host(sensor())) == b"\0\0"


def test_while_it_ranges_it_takes_no_notice_of_the_line() -> None:
    host = Host(sensor(3.0))
    host.ask(b"\x00\x51", within_ns=2 * BYTE_NS + RANGING_NS - 2 * BYTE_NS - 2)
    assert host.ask(b"\x00\x5e") == b""
    assert host.ask(b"\x00\x5e") == bytes.fromhex("012C")


def test_of_several_on_a_line_the_one_that_is_meant_answers() -> None:
    sensors = [sensor(n / 2 + 1, name=str(n), address=n) for n in range(16)]
    host = Host(*sensors)
    for n in range(16):
        assert ranged(host, address=n) == round(50 * n + 100).to_bytes(2, "big")


def test_all_of_them_may_range_at_once() -> None:
    host = Host(sensor(1.0, name="a"), sensor(2.0, name="b", address=1))
    host.ask(b"\x00\x51\x01\x51", within_ns=80 * MS)
    assert (host.ask(b"\x00\x5e"), host.ask(b"\x01\x5e")) == (b"\0\x64", b"\0\xc8")


@pytest.mark.parametrize("rest", [b"\x00", b"\x51", b"\x07", b"\x07\x51\x5e", b"\x5e\x5e"])
def test_what_is_lost_costs_one_command_and_no_more(rest: bytes) -> None:
    host = Host(sensor(3.0))
    assert host.ask(rest) == b""
    assert ranged(host) == bytes.fromhex("012C")


def test_the_version_is_one_byte() -> None:
    assert Host(sensor(revision=9)).ask(b"\x00\x5d") == b"\x09"


def test_its_dead_zone_shrinks_in_six_pings_and_a_sound_that_is_gone_by_then_is_missed() -> None:
    host = Host(Srf02SerialSensor("front", room(0.2, 1.0), Random(1)))
    said = []
    for _ in range(8):
        value = int.from_bytes(ranged(host), "big")
        said.append((value, int.from_bytes(host.ask(b"\x00\x5f"), "big")))
    assert [minimum for _, minimum in said] == [28, 26, 24, 22, 19, 17, 15, 15]
    assert [value for value, _ in said] == [100, 100, 100, 22, 20, 20, 20, 20]


def test_it_can_be_told_to_tune_itself_anew_and_does_so_after_a_power_cut() -> None:
    device = Srf02SerialSensor("front", room(1.0), Random(1))
    host = Host(device)
    for _ in range(7):
        ranged(host)
    host.ask(b"\x00\x60")
    ranged(host)
    assert host.ask(b"\x00\x5f") == b"\0\x1c"
    device.fault("off", host.now_ns, 10 * MS)
    host.wait(20 * MS)
    assert (host.ask(b"\x00\x5e"), host.ask(b"\x00\x5f")) == (b"\0\0", b"\0\0")


def test_it_listens_without_a_ping() -> None:
    pings: list[int] = []
    device = Srf02SerialSensor("front", room(1.0, pings=pings), Random(1))
    host = Host(device)
    assert ranged(host, 0x57) == b"\0\0"
    assert pings == []
    ranged(host, 0x51)
    host.ask(b"\x00\x5c")
    assert len(pings) == 2


def test_in_cold_air_microseconds_are_true_and_centimetres_are_not() -> None:
    def cold() -> Host:
        options = Srf02SerialOptions(first_minimum=0.15)
        return Host(Srf02SerialSensor("front", room(3.0, speed=325.0), Random(1), options))

    assert int.from_bytes(ranged(cold(), 0x52), "big") == round(6 / 325.0 * 1e6)
    assert int.from_bytes(ranged(cold(), 0x51), "big") == round(300 * SPEED / 325.0)


def test_it_moves_to_another_address_for_good() -> None:
    device = sensor(3.0)
    host = Host(device)
    for message in (b"\x00\xa0", b"\x00\xaa", b"\x00\xa5", b"\x00\x07"):
        assert host.ask(message) == b""
    assert (host.ask(b"\x00\x5e"), ranged(host, address=7)) == (b"", bytes.fromhex("012C"))
    device.fault("off", host.now_ns, MS)
    host.wait(10 * MS)
    assert ranged(host, address=7) == bytes.fromhex("012C")


def test_a_move_with_something_in_between_is_none() -> None:
    host = Host(sensor(3.0))
    for message in (b"\x00\xa0", b"\x00\xaa", b"\x00\x5d", b"\x00\xa5", b"\x00\x07"):
        host.ask(message)
    assert ranged(host) == bytes.fromhex("012C")


@pytest.mark.parametrize(
    ("options", "words"),
    [({"address": 16}, "address 16 is not one"), ({"minimum": 0.5}, "minimum 0.5 is not between")],
)
def test_impossible_options_are_refused(options: dict[str, float], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Srf02SerialOptions(**options)  # type: ignore[arg-type]


def test_garbage_is_other_bytes_and_as_many_as_it_likes() -> None:
    device = sensor(3.0)
    host = Host(device)
    device.fault("garbage", 0)
    replies = [host.ask(b"\x00\x5e") for _ in range(40)]
    assert {len(reply) for reply in replies} == {1, 2, 3, 4}
    assert bytes.fromhex("012C") not in replies


def test_two_at_one_address_garble_each_other() -> None:
    device = sensor(3.0)
    host = Host(device)
    device.fault("address_conflict", 0)
    ranged(host)
    assert len({host.ask(b"\x00\x5e") for _ in range(20)}) > 3


def test_delayed_is_late_by_200_ms() -> None:
    device = sensor(3.0)
    host = Host(device)
    device.fault("delayed", 0)
    assert host.ask(b"\x00\x5e", within_ns=200 * MS) == b""
    assert host.wait(20 * MS) == b"\0\0"


def test_slow_takes_five_times_as_long() -> None:
    device = sensor(3.0)
    host = Host(device)
    device.fault("slow", 0)
    host.ask(b"\x00\x51", within_ns=5 * RANGING_NS)
    assert host.ask(b"\x00\x5e", within_ns=2 * BYTE_NS) == b""
    assert host.ask(b"\x00\x5e") == bytes.fromhex("012C")
