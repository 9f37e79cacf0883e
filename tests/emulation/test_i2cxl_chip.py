from random import Random

from hypothesis import given
from hypothesis.strategies import floats, integers
from pytest import mark, raises

from echogrid.emulation.devices.i2cxl import I2cxlChip, I2cxlOptions
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

from .i2c_host import ENXIO, MS, SPEED, Host, room, wall

OWN = 344.8
PLAIN = I2cxlOptions()


def host(*echoes: Echo, options: I2cxlOptions = PLAIN, speed: float = OWN) -> Host:
    return Host(I2cxlChip("front", room(*echoes, speed=speed), Random(1), options))


def ping(each: Host) -> bytes:
    """Fire, wait, read."""
    each.write(0x51)
    each.wait(80)
    return each.take(2).data


def test_a_wall_at_three_metres_reads_as_the_bytes_01_2c() -> None:
    assert ping(host(wall(3.0))) == bytes.fromhex("012C")


def test_nothing_heard_reads_as_765() -> None:
    for echoes in ((), (wall(7.7),), (wall(1.0, margin=-1.0),)):
        assert ping(host(*echoes)) == bytes.fromhex("02FD")


def test_nothing_heard_may_read_otherwise() -> None:
    assert ping(host(options=I2cxlOptions(no_echo_cm=0))) == b"\0\0"


@given(floats(0.001, 0.2))
def test_all_that_is_nearer_reads_as_the_minimum(distance: float) -> None:
    assert ping(host(wall(distance))) == bytes((0, 20))
    assert ping(host(wall(distance), options=I2cxlOptions(minimum_cm=25))) == bytes((0, 25))


def test_centimetres_are_by_its_own_speed_of_sound() -> None:
    cold = 325.0
    assert ping(host(wall(3.0), speed=cold)) == round(300 * OWN / cold).to_bytes(2, "big")


@mark.parametrize("count", [1, 2])
def test_before_the_first_ranging_it_tells_what_part_it_is(count: int) -> None:
    each = host(wall(3.0))
    assert each.take(count).data == bytes.fromhex("010A")[:count]
    ping(each)
    each.power_cycle()
    assert each.take(count).data == bytes.fromhex("010A")[:count]


def test_the_last_range_can_be_read_again() -> None:
    each = host(wall(3.0))
    assert ping(each) == each.take(2).data == bytes.fromhex("012C")


def test_behind_the_range_nobody_drives_the_bus() -> None:
    each = host(wall(3.0))
    ping(each)
    assert each.take(4).data == bytes.fromhex("012CFFFF")


def test_while_ranging_it_does_not_acknowledge() -> None:
    each = host(wall(1.0))
    end_ns = each.write(0x51).end_ns
    each.now_ns = end_ns + 64 * MS
    assert each.take(2).errno == each.write(0x51).errno == ENXIO
    each.now_ns = end_ns + 65 * MS
    assert each.take(2).data == bytes((0, 100))


def test_a_quicker_one_is_ready_sooner_and_hears_no_farther_than_the_sound_got() -> None:
    quick = I2cxlOptions(ranging_ns=10 * MS)
    for distance, answer in ((1.7, 170), (1.75, 765)):
        each = host(wall(distance), options=quick)
        each.write(0x51)
        each.wait(10)
        assert each.take(2).data == answer.to_bytes(2, "big")


@mark.parametrize("data", [(0x00,), (0x50,), (0x00, 0x51), (0x51, 0x00), (0x52,)])
def test_other_messages_change_nothing(data: tuple[int, ...]) -> None:
    each = host(wall(3.0))
    assert each.write(*data).errno == 0
    assert each.take(2).data == bytes.fromhex("010A")


@given(integers(0, 0xFF))
def test_its_address_changes_to_even_ones_that_are_not_refused(new: int) -> None:
    each = host(wall(3.0))
    each.write(0xAA, 0xA5, new)
    even = new - new % 2
    moved = even not in (0, 80, 164, 170)
    assert each.chip.address == (even // 2 if moved else 0x70)
    assert (each.take(2).errno == 0) == (not moved or even == 0xE0)


def test_a_new_address_outlasts_the_power() -> None:
    each = host(wall(3.0))
    each.write(0xAA, 0xA5, 0xE2)
    each.address = 0x71
    each.power_cycle()
    assert ping(each) == bytes.fromhex("012C")


@mark.parametrize("data", [(0xAA, 0xA5), (0xA5, 0xAA, 0xE2), (0xAA, 0xA5, 0xE2, 0x00)])
def test_no_other_message_moves_it(data: tuple[int, ...]) -> None:
    each = host()
    each.write(*data)
    assert each.chip.address == 0x70


def test_the_scene_is_asked_for_the_time_of_fire_when_it_has_listened() -> None:
    asked: list[int] = []
    pings: list[int] = []

    def scene(fire_ns: int) -> tuple[Echo, ...]:
        asked.append(fire_ns)
        return ()

    each = Host(I2cxlChip("front", Surroundings(scene, SPEED, ping=pings.append), Random(1)))
    end_ns = each.write(0x51).end_ns
    assert (asked, pings) == ([], [end_ns])
    each.wait(80)
    each.take(2)
    assert asked == [end_ns]


def test_impossible_options_are_refused() -> None:
    with raises(ValueError, match="address 0x80"):
        I2cxlOptions(address=0x80)
    with raises(ValueError, match="ranging_ns 0"):
        I2cxlOptions(ranging_ns=0)
