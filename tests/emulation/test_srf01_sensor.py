from random import Random

import pytest

from echogrid.emulation.devices.srf01 import Srf01Options, Srf01Sensor

from .line_host import BREAK, MS, Host, room


def sensor(*distances: float, name: str = "front", **options: int) -> Srf01Sensor:
    return Srf01Sensor(name, room(*distances), Random(1), Srf01Options(**options))


def asked(host: Host, command: int, address: int = 1, within_ns: int = 20 * MS) -> bytes:
    """What comes behind one's own echo."""
    echo = bytes((0, address, command))
    heard = host.ask(BREAK, echo[1:], within_ns=within_ns)
    assert heard.startswith(echo)
    return heard[len(echo) :]


def ranged(host: Host, command: int = 0x51, address: int = 1) -> bytes:
    asked(host, command, address, 80 * MS)
    return asked(host, 0x5E, address)


def test_the_host_hears_its_break_and_its_bytes_and_then_the_answer() -> None:
    host = Host(sensor(3.0))
    assert host.ask(BREAK, b"\x01\x51", within_ns=80 * MS) == b"\x00\x01\x51"
    assert host.ask(BREAK, b"\x01\x5e") == b"\x00\x01\x5e\x01\x2c"


@pytest.mark.parametrize(("command", "value"), [(0x50, 118), (0x51, 300)])
def test_each_ranging_command_has_its_unit(command: int, value: int) -> None:
    assert int.from_bytes(ranged(Host(sensor(3.0)), command), "big") == value


@pytest.mark.parametrize(("command", "value"), [(0x53, 118), (0x54, 300)])
def test_some_commands_send_the_answer_when_the_ranging_is_over(command: int, value: int) -> None:
    host = Host(sensor(3.0))
    assert int.from_bytes(asked(host, command, within_ns=80 * MS), "big") == value


def test_without_a_break_it_does_not_listen() -> None:
    host = Host(sensor(3.0))
    assert host.ask(b"\x01\x5d") == b"\x01\x5d"
    assert asked(host, 0x5D) == b"\x01"


def test_one_break_is_for_one_command() -> None:
    host = Host(sensor(3.0))
    assert host.ask(BREAK, b"\x01\x5d") == b"\x00\x01\x5d\x01"
    assert host.ask(b"\x01\x5d") == b"\x01\x5d"


def test_where_breaks_don_t_show_it_listens_without() -> None:
    host = Host(sensor(3.0))
    host.line.lose_breaks()
    assert host.ask(b"\x01\x5d") == b"\x01\x5d\x01"


def test_a_break_while_it_ranges_goes_by() -> None:
    host = Host(sensor(3.0))
    asked(host, 0x51, within_ns=30 * MS)
    assert asked(host, 0x5D) == b""
    host.wait(60 * MS)
    assert host.ask(b"\x01\x5d") == b"\x01\x5d"


def test_of_several_on_the_wire_the_one_that_is_meant_answers() -> None:
    host = Host(sensor(1.0, name="a"), sensor(2.0, name="b", address=16))
    assert (ranged(host, address=1), ranged(host, address=16)) == (b"\0\x64", b"\0\xc8")


def test_after_some_pings_it_is_locked_and_hears_all_the_way_down() -> None:
    host = Host(sensor(0.1, 1.0))
    said = [(asked(host, 0x5F), ranged(host)) for _ in range(8)]
    assert [status for status, _ in said] == [b"\x02"] * 6 + [b"\x03"] * 2
    assert [value for _, value in said] == [b"\0\x64"] * 6 + [b"\0\x0a"] * 2


def test_without_the_advanced_mode_it_stays_deaf_near_by() -> None:
    host = Host(sensor(0.05, 1.0, locking_pings=0))
    assert ranged(host) == b"\0\x05"
    asked(host, 0x63)
    assert (asked(host, 0x5F), ranged(host)) == (b"\x01", b"\0\x64")
    asked(host, 0x62)
    assert asked(host, 0x5F) == b"\x03"


def test_it_can_be_unlocked_and_a_power_cut_does_so_too() -> None:
    device = sensor(1.0, locking_pings=1, advanced=0)
    host = Host(device)
    ranged(host)
    assert asked(host, 0x5F) == b"\x01"
    asked(host, 0x61)
    assert asked(host, 0x5F) == b"\x00"
    ranged(host)
    device.fault("off", host.now_ns, MS)
    host.wait(10 * MS)
    assert asked(host, 0x5F) == b"\x00"


def test_it_listens_without_a_ping() -> None:
    pings: list[int] = []
    host = Host(Srf01Sensor("front", room(1.0, pings=pings), Random(1)))
    assert (ranged(host, 0x57), asked(host, 0x5A, within_ns=80 * MS), pings) == (b"\0\0", b"\0\0", [])


def test_it_moves_to_another_address() -> None:
    host = Host(sensor(3.0))
    for last in (0xA0, 0xAA, 0xA5, 0x10):
        asked(host, last)
    assert (asked(host, 0x5D), asked(host, 0x5D, address=16)) == (b"", b"\x01")


def test_an_address_that_it_can_t_have_is_refused() -> None:
    with pytest.raises(ValueError, match="address 0 is not one of an SRF01"):
        Srf01Options(address=0)
