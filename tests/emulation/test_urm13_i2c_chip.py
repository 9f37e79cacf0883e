from random import Random

from pytest import mark, raises

from echogrid.emulation.devices.urm13_i2c import Urm13I2cChip, Urm13I2cOptions
from echogrid.emulation.scene import Echo

from .i2c_host import MS, SPEED, Host, room, wall

CONFIGURATION, COMMAND = 0x09, 0x0A
FAR, NEAR = 0x04, 0x14


def host(*echoes: Echo, configuration: int = FAR, speed: float = SPEED) -> Host:
    options = Urm13I2cOptions(configuration=configuration)
    return Host(Urm13I2cChip("front", room(*echoes, speed=speed), Random(1), options))


def ping(each: Host) -> int:
    """Fire, wait, and read the distance."""
    each.write(COMMAND, 0x01)
    each.wait(100)
    return int.from_bytes(each.read(0x03, 2), "big")


def test_its_registers() -> None:
    each = host(wall(3.0), speed=343.21)
    assert each.read(0x00, 13) == bytes.fromhex("12 02 10 FFFF 00C8 0000 04 00 00 00")
    ping(each)
    assert each.read(0x00, 13) == bytes.fromhex("12 02 10 012C 00C8 0000 04 00 00 00")


@mark.parametrize(
    ("configuration", "distance", "read"),
    [
        *((FAR, 0.39, 0xFFFF), (FAR, 0.4, 40), (FAR, 9.0, 900), (FAR, 9.1, 0xFFFF)),
        *((NEAR, 0.14, 0xFFFF), (NEAR, 0.15, 15), (NEAR, 1.5, 150), (NEAR, 1.6, 0xFFFF)),
    ],
)
def test_it_hears_from_15_to_150_or_from_40_to_900_centimetres(
    configuration: int, distance: float, read: int
) -> None:
    assert ping(host(wall(distance), configuration=configuration)) == read


@mark.parametrize(("configuration", "ms"), [(NEAR, 20), (FAR, 95)])
def test_until_the_ranging_is_over_it_tells_the_ping_before(configuration: int, ms: int) -> None:
    each = host(wall(1.0), configuration=configuration)
    end_ns = each.write(COMMAND, 0x01).end_ns
    each.now_ns = end_ns + (ms - 1) * MS
    assert each.read(0x03, 2) == b"\xff\xff"
    each.now_ns = end_ns + ms * MS
    assert each.read(0x03, 2) == bytes((0, 100))


def test_distances_are_true_in_cold_air_for_it_has_a_thermometer() -> None:
    each = host(wall(3.0), speed=325.18)
    assert ping(each) == 300
    assert int.from_bytes(each.read(0x05, 2), "big", signed=True) == -100


def test_its_configuration_outlasts_the_power_and_its_distance_does_not() -> None:
    each = host(wall(1.0))
    each.write(CONFIGURATION, NEAR)
    ping(each)
    each.power_cycle()
    assert each.read(CONFIGURATION, 1) == bytes((NEAR,))
    assert each.read(0x03, 2) == b"\xff\xff"


def test_without_the_passive_bit_it_ranges_by_itself_and_does_so_again_after_a_power_cut() -> None:
    each = host(wall(1.0))
    each.write(CONFIGURATION, 0x10)
    each.wait(25)
    assert each.read(0x03, 2) == bytes((0, 100))
    each.power_cycle()
    each.wait(25)
    assert each.read(0x03, 2) == bytes((0, 100))


def test_a_command_bit_that_is_zero_does_nothing() -> None:
    each = host(wall(1.0))
    each.write(COMMAND, 0x00)
    each.wait(100)
    assert each.read(0x03, 2) == b"\xff\xff"


def test_impossible_options_are_refused() -> None:
    with raises(ValueError, match="address 0x78"):
        Urm13I2cOptions(address=0x78)
    with raises(ValueError, match="configuration 0x8"):
        Urm13I2cOptions(configuration=0x08)
