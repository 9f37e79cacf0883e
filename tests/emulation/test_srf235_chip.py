from random import Random

import pytest

from echogrid.emulation.devices.srf235 import Srf235Chip, Srf235Options
from echogrid.emulation.scene import Echo

from .i2c_host import ENXIO, MS, SPEED, Host, room, wall

USUAL = Srf235Options()


def host(*echoes: Echo, options: Srf235Options = USUAL, speed: float = SPEED) -> Host:
    return Host(Srf235Chip("pencil", room(*echoes, speed=speed), Random(1), options))


def ranged(host: Host, command: int = 0x51) -> int:
    host.write(0, command)
    host.wait(10)
    return int.from_bytes(host.read(2, 2), "big")


def test_version_unused_and_range_are_four_registers() -> None:
    device = host(wall(0.85))
    ranged(device)
    assert device.read(0, 6) == bytes((3, 0x80, 0, 85, 0, 0))


@pytest.mark.parametrize(("command", "value"), [(0x50, 33), (0x51, 85), (0x52, 4956)])
def test_each_ranging_command_has_its_unit(command: int, value: int) -> None:
    assert ranged(host(wall(0.85)), command) == value


def test_it_may_count_in_millimetres() -> None:
    assert ranged(host(wall(0.85), options=Srf235Options(unit_mm=1.0))) == 850


def test_in_cold_air_microseconds_are_true_and_centimetres_are_not() -> None:
    device = host(wall(1.0), speed=325.0)
    assert ranged(device, 0x52) == round(2e6 / 325.0)
    assert ranged(device) == round(100 * 343.0 / 325.0)


def test_it_ranges_for_ten_milliseconds_in_which_it_does_not_acknowledge() -> None:
    device = host(wall(1.0))
    ping = device.write(0, 0x51)
    device.now_ns = ping.end_ns + 10 * MS - 1
    assert device.take(1).errno == ENXIO
    device.now_ns = ping.end_ns + 10 * MS
    assert device.take(1).errno == 0


def test_it_is_deaf_up_to_ten_centimetres_but_for_a_sound_that_goes_on() -> None:
    assert ranged(host(wall(0.05))) == 0
    assert ranged(host(wall(0.05), wall(0.5))) == 50
    assert ranged(host(wall(0.097))) == 10
    assert ranged(host(wall(0.1001))) == 10


def test_what_comes_after_it_has_done_is_not_heard() -> None:
    assert ranged(host(wall(1.71))) == 171
    assert ranged(host(wall(1.72))) == 0


def test_nothing_heard_is_zero() -> None:
    assert ranged(host()) == 0
    assert ranged(host(wall(1.0, margin=-0.1))) == 0


def test_it_has_no_settings() -> None:
    device = host(wall(1.0, margin=1.0))
    device.write(1, 0)
    device.write(2, 0)
    assert ranged(device) == 100


def test_four_messages_give_it_another_address_for_good() -> None:
    device = host(wall(1.0))
    for value in (0xA0, 0xAA, 0xA5, 0xE2):
        device.write(0, value)
    assert device.take(1).errno == ENXIO
    device.address = 0x71
    device.power_cycle()
    assert ranged(device) == 100


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"unit_mm": 0.0}, "unit_mm 0.0 is no unit"),
        ({"address": 0x20}, "address 0x20 is not one of a Devantech ranger"),
    ],
)
def test_impossible_options_are_refused(options: dict[str, float], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        Srf235Options(**options)  # type: ignore[arg-type]  # that is what is tried
