from random import Random

import pytest

from echogrid.emulation.devices.srf02 import Srf02Chip, Srf02Options
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

from .i2c_host import ENXIO, MS, SPEED, Host, room, wall

USUAL = Srf02Options()


def host(*echoes: Echo, options: Srf02Options = USUAL) -> Host:
    return Host(Srf02Chip("two", room(*echoes), Random(1), options))


def ranged(host: Host, command: int = 0x51) -> tuple[int, int]:
    """Range and minimum after a ranging."""
    host.write(0, command)
    host.wait(65)
    data = host.read(2, 4)
    return int.from_bytes(data[:2], "big"), int.from_bytes(data[2:], "big")


def test_a_wall_at_three_metres_reads_as_the_bytes_01_2c_in_centimetres() -> None:
    device = host(wall(3.0))
    device.write(0x00, 0x51)
    device.wait(65)
    assert device.read(2, 2) == bytes.fromhex("01 2C")
    assert device.read(0, 2) == bytes.fromhex("06 80")


@pytest.mark.parametrize(
    ("command", "value", "minimum"), [(0x50, 118, 11), (0x51, 300, 28), (0x52, 17493, 1633)]
)
def test_range_and_minimum_are_in_the_unit_of_the_command(command: int, value: int, minimum: int) -> None:
    assert ranged(host(wall(3.0)), command) == (value, minimum)


def test_the_minimum_shrinks_within_six_pings_and_stays() -> None:
    device = host(wall(3.0))
    minima = [ranged(device)[1] for _ in range(9)]
    assert minima == [28, 26, 24, 22, 19, 17, 15, 15, 15]


def test_where_it_begins_and_ends_can_be_chosen() -> None:
    device = host(options=Srf02Options(first_minimum=0.30, minimum=0.12))
    assert [ranged(device)[1] for _ in range(7)] == [30, 27, 24, 21, 18, 15, 12]


@pytest.mark.parametrize("restart", ["power", "command"])
def test_power_up_and_the_command_60_restart_the_tuning(restart: str) -> None:
    device = host(wall(3.0))
    for _ in range(7):
        ranged(device)
    if restart == "power":
        device.power_cycle()
    else:
        device.write(0, 0x60)
        assert device.take(1).errno == 0
    assert ranged(device)[1] == 28


def test_what_is_nearer_than_the_minimum_is_missed_and_what_lies_behind_is_heard() -> None:
    device = host(wall(0.2), wall(1.0))
    assert ranged(device) == (100, 28)
    assert ranged(host(wall(0.2))) == (0, 28)


def test_a_sound_that_is_still_there_when_it_begins_to_hear_reads_as_the_minimum() -> None:
    """The burst lasts 0.2 ms, 3.4 cm of the way."""
    assert ranged(host(wall(0.26)))[0] == 28
    assert ranged(host(wall(0.24)))[0] == 0


def test_nothing_heard_is_zero() -> None:
    assert ranged(host())[0] == 0
    assert ranged(host(wall(3.0, margin=-1.0)))[0] == 0


def test_while_ranging_it_does_not_acknowledge() -> None:
    device = host(wall(1.0))
    ping = device.write(0, 0x51)
    device.now_ns = ping.end_ns + 64 * MS
    assert device.take(1).errno == ENXIO
    device.now_ns = ping.end_ns + 65 * MS
    assert device.take(1).errno == 0


def test_a_quick_one_is_ready_sooner_and_hears_less_far() -> None:
    device = host(wall(1.5), wall(2.0), options=Srf02Options(ranging_ns=10 * MS))
    ping = device.write(0, 0x51)
    device.now_ns = ping.end_ns + 10 * MS
    assert device.read(2, 2) == bytes((0, 150))
    assert ranged(host(wall(2.0), options=Srf02Options(ranging_ns=10 * MS)))[0] == 0


def played(foreign: tuple[Echo, ...]) -> tuple[Host, list[int]]:
    """A chip in an empty room in which others ping, and when it pinged."""
    pings: list[int] = []
    surroundings = Surroundings(lambda fire_ns: (), SPEED, lambda start_ns: foreign, pings.append)
    return Host(Srf02Chip("two", surroundings, Random(1))), pings


@pytest.mark.parametrize(("command", "value"), [(0x56, 79), (0x57, 200), (0x58, 11662)])
def test_a_fake_ranging_hears_others_and_makes_no_sound(command: int, value: int) -> None:
    device, pings = played((Echo(2.0, 20.0, "crosstalk"),))
    assert ranged(device, command)[0] == value
    assert pings == []
    assert ranged(device, 0x51)[0] == 0
    assert len(pings) == 1


def test_a_fake_ranging_does_not_tune() -> None:
    device = host()
    for _ in range(9):
        ranged(device, 0x57)
    assert ranged(device)[1] == 28


def test_a_burst_is_a_ping_and_no_ranging() -> None:
    device, pings = played(())
    burst = device.write(0, 0x5C)
    assert device.take(1).errno == 0
    assert pings == [burst.end_ns]


def test_only_the_command_register_can_be_written() -> None:
    device = host(wall(1.0))
    device.write(1, 0x51)
    device.write(2, 0xFF)
    assert device.read(1, 3) == bytes((0x80, 0, 0))


def test_it_takes_no_general_call() -> None:
    device = host(wall(1.0))
    device.address = 0
    assert device.write(0, 0x51).errno == ENXIO


def test_four_messages_give_it_another_address_for_good() -> None:
    device = host(wall(1.0))
    for value in (0xA0, 0xAA, 0xA5, 0xFE):
        device.write(0, value)
    assert device.take(1).errno == ENXIO
    device.address = 0x7F
    device.power_cycle()
    assert ranged(device)[0] == 100


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"minimum": 0.0}, "minimum 0.0 is not between 0 and first_minimum"),
        ({"minimum": 0.4}, "minimum 0.4 is not between 0 and first_minimum"),
        ({"ranging_ns": 0}, "ranging_ns 0 is no time"),
        ({"address": 0x20}, "address 0x20 is not one of a Devantech ranger"),
    ],
)
def test_impossible_options_are_refused(options: dict[str, float], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        Srf02Options(**options)  # type: ignore[arg-type]  # that is what is tried
