from random import Random

from pytest import mark, raises

from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.devices.urm09 import Urm09Chip, Urm09Options
from echogrid.emulation.scene import Echo

from .i2c_host import ENXIO, MS, SPEED, Host, room, wall

AT_20_CELSIUS = 343.21
CONFIGURATION, COMMAND = 0x07, 0x08


def host(*echoes: Echo, configuration: int = 0x20, speed: float = SPEED) -> Host:
    options = Urm09Options(configuration=configuration)
    return Host(Urm09Chip("front", room(*echoes, speed=speed), Random(1), options))


def ping(each: Host) -> int:
    """Fire, wait, and read the distance."""
    each.write(COMMAND, 0x01)
    each.wait(100)
    return int.from_bytes(each.read(0x03, 2), "big")


def test_its_registers() -> None:
    each = host(wall(3.0), speed=AT_20_CELSIUS)
    assert each.read(0x00, 9) == bytes.fromhex("11 01 10 0000 00C8 20 00")
    ping(each)
    assert each.read(0x00, 9) == bytes.fromhex("11 01 10 012C 00C8 20 00")


def test_it_acknowledges_while_it_ranges_and_tells_the_ping_before() -> None:
    each = host(wall(3.0))
    assert ping(each) == 300
    each.chip.fault("wrong", each.now_ns)
    end_ns = each.write(COMMAND, 0x01).end_ns
    each.now_ns = end_ns + 89 * MS
    assert each.read(0x03, 2) == bytes.fromhex("012C")
    each.now_ns = end_ns + 90 * MS
    assert each.read(0x03, 2) == (450).to_bytes(2, "big")


@mark.parametrize(("configuration", "heard"), [(0x00, [120]), (0x10, [120, 290]), (0x20, [120, 290, 490])])
def test_its_ranges_reach_one_and_a_half_three_and_five_metres(configuration: int, heard: list[int]) -> None:
    distances = [ping(host(wall(distance), configuration=configuration)) for distance in (1.2, 2.9, 4.9, 5.1)]
    assert distances == heard + [0xFFFF] * (4 - len(heard))


@mark.parametrize(("configuration", "ms"), [(0x00, 20), (0x10, 50), (0x20, 90)])
def test_a_shorter_range_takes_less_time(configuration: int, ms: int) -> None:
    each = host(wall(1.0), configuration=configuration)
    each.now_ns = each.write(COMMAND, 0x01).end_ns + ms * MS
    assert each.read(0x03, 2) == bytes((0, 100))


def test_nothing_heard_reads_as_ffff() -> None:
    assert ping(host()) == ping(host(wall(1.0, margin=-1.0))) == 0xFFFF


def test_nearer_than_two_centimetres_it_hears_nothing_of_an_obstacle() -> None:
    assert ping(host(wall(0.01), wall(2.0))) == 200


def test_distances_are_true_in_cold_air_for_it_has_a_thermometer() -> None:
    each = host(wall(3.0), speed=325.18)
    assert ping(each) == 300
    assert int.from_bytes(each.read(0x05, 2), "big", signed=True) == -100


def test_set_to_it_it_ranges_by_itself() -> None:
    asked: list[int] = []

    def scene(fire_ns: int) -> tuple[Echo, ...]:
        asked.append(fire_ns)
        return (wall(1.0),)

    each = Host(Urm09Chip("front", Surroundings(scene, SPEED), Random(1), Urm09Options()))
    each.write(CONFIGURATION, 0x80)
    each.wait(100)
    assert each.read(0x03, 2) == bytes((0, 100))
    assert len(asked) == 5
    each.write(CONFIGURATION, 0x00)
    each.wait(1000)
    each.read(0x03, 2)
    assert len(asked) == 6


def test_it_may_range_by_itself_from_the_beginning() -> None:
    each = host(wall(1.0), configuration=0x80)
    each.wait(100)
    assert each.read(0x03, 2) == bytes((0, 100))


def test_a_command_while_it_ranges_is_passed_over() -> None:
    each = host(wall(1.0))
    end_ns = each.write(COMMAND, 0x01).end_ns
    each.wait(60)
    assert each.write(COMMAND, 0x01).errno == 0
    each.now_ns = end_ns + 90 * MS
    assert each.read(0x03, 2) == bytes((0, 100))


def test_configuration_and_distance_are_lost_with_the_power() -> None:
    each = host(wall(1.0), configuration=0x00, speed=AT_20_CELSIUS)
    each.write(CONFIGURATION, 0x20)
    ping(each)
    each.power_cycle()
    assert each.read(0x03, 5) == bytes.fromhex("0000 00C8 00")


def test_a_range_that_there_is_not_is_not_taken() -> None:
    each = host(configuration=0x10)
    each.write(CONFIGURATION, 0x30)
    assert each.read(CONFIGURATION, 1) == b"\x10"


def test_a_new_address_is_taken_up_with_the_next_power() -> None:
    each = host(wall(1.0))
    each.write(0x00, 0x22)
    assert each.read(0x00, 1) == b"\x22"
    each.power_cycle()
    assert each.take(1).errno == ENXIO
    each.address = 0x22
    assert ping(each) == 100


@mark.parametrize("address", [0x07, 0x78, 0x00])
def test_an_address_out_of_bounds_is_not_taken(address: int) -> None:
    each = host()
    each.write(0x00, address)
    each.power_cycle()
    assert each.read(0x00, 1) == b"\x11"


def test_impossible_options_are_refused() -> None:
    with raises(ValueError, match="address 0x7"):
        Urm09Options(address=0x07)
    with raises(ValueError, match="configuration 0x30"):
        Urm09Options(configuration=0x30)
    with raises(ValueError, match="configuration 0x1"):
        Urm09Options(configuration=0x01)
