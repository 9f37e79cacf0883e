from random import Random

from hypothesis import given
from hypothesis.strategies import floats
from pytest import mark, raises

from echogrid.emulation.devices.rcwl9620 import Rcwl9620Chip, Rcwl9620Options
from echogrid.emulation.scene import Echo

from .i2c_host import MS, Host, room, wall

NOTHING = bytes.fromhex("44AA20")
"""4.5 m."""
PLAIN = Rcwl9620Options()


def host(*echoes: Echo, options: Rcwl9620Options = PLAIN, speed: float = 343.0) -> Host:
    return Host(Rcwl9620Chip("front", room(*echoes, speed=speed), Random(1), options))


def ping(each: Host) -> bytes:
    """Fire, wait, read."""
    each.write(0x01)
    each.wait(120)
    return each.take(3).data


def test_a_wall_reads_as_micrometres_high_byte_first() -> None:
    assert ping(host(wall(1.234567))) == bytes.fromhex("12D687")


def test_nothing_heard_reads_as_four_and_a_half_metres() -> None:
    assert ping(host()) == ping(host(wall(4.6))) == ping(host(wall(1.0, margin=-1.0))) == NOTHING


def test_read_too_early_it_says_that_it_hears_nothing() -> None:
    each = host(wall(1.0))
    assert each.take(3).data == NOTHING
    end_ns = each.write(0x01).end_ns
    each.now_ns = end_ns + 109 * MS
    assert each.take(3).data == NOTHING
    each.now_ns = end_ns + 110 * MS
    assert each.take(3).data == (1_000_000).to_bytes(3, "big")


def test_the_ping_before_is_forgotten_with_the_next() -> None:
    each = host(wall(1.0))
    ping(each)
    each.write(0x01)
    assert each.take(3).data == NOTHING


def test_a_command_while_it_ranges_is_passed_over() -> None:
    each = host(wall(1.0))
    end_ns = each.write(0x01).end_ns
    each.wait(60)
    assert each.write(0x01).errno == 0
    each.now_ns = end_ns + 110 * MS
    assert each.take(3).data != NOTHING


@given(floats(0.001, 0.02))
def test_nearer_than_two_centimetres_reads_as_two(distance: float) -> None:
    assert ping(host(wall(distance))) == (20_000).to_bytes(3, "big")


def test_micrometres_are_by_its_own_speed_of_sound() -> None:
    fast = Rcwl9620Options(speed_of_sound=350.0)
    assert ping(host(wall(1.0), options=fast)) == (1_020_408).to_bytes(3, "big")


def test_without_power_it_forgets_its_range() -> None:
    each = host(wall(1.0))
    ping(each)
    each.power_cycle()
    assert each.take(3).data == NOTHING


@mark.parametrize("data", [(0x00,), (0x02,), (0x51,)])
def test_other_messages_change_nothing(data: tuple[int, ...]) -> None:
    each = host(wall(1.0))
    assert each.write(*data).errno == 0
    each.wait(120)
    assert each.take(3).data == NOTHING


def test_behind_the_range_nobody_drives_the_bus() -> None:
    assert host().take(5).data == NOTHING + b"\xff\xff"


def test_an_impossible_address_is_refused() -> None:
    with raises(ValueError, match="address 0x7"):
        Rcwl9620Options(address=0x07)
