from math import log10
from random import Random

import pytest

from echogrid.emulation.devices.srf10 import Srf10Chip, Srf10Options
from echogrid.emulation.scene import Echo

from .i2c_host import ENXIO, MS, Host, room, wall


def host(*echoes: Echo) -> Host:
    return Host(Srf10Chip("ten", room(*echoes), Random(1), Srf10Options()))


def ranged(host: Host, command: int = 0x51) -> int:
    host.write(0, command)
    host.wait(65)
    return int.from_bytes(host.read(2, 2), "big")


def test_a_wall_at_three_metres_reads_as_the_bytes_01_2c_in_centimetres() -> None:
    device = host(wall(3.0))
    ranged(device)
    assert device.read(0, 4) == bytes.fromhex("07 80 01 2C")


@pytest.mark.parametrize(("command", "value"), [(0x50, 118), (0x51, 300), (0x52, 17493)])
def test_each_ranging_command_has_its_unit(command: int, value: int) -> None:
    assert ranged(host(wall(3.0)), command) == value


def test_it_tells_the_first_echo_alone_and_has_four_registers() -> None:
    device = host(wall(1.0), wall(2.0))
    assert ranged(device) == 100
    assert device.read(4, 4) == bytes(4)


def test_nothing_heard_is_zero() -> None:
    assert ranged(host()) == 0


def test_while_ranging_it_does_not_acknowledge() -> None:
    device = host(wall(1.0))
    ping = device.write(0, 0x51)
    device.now_ns = ping.end_ns + 64 * MS
    assert device.take(1).errno == ENXIO
    device.now_ns = ping.end_ns + 65 * MS
    assert device.take(1).errno == 0


def test_the_range_register_shortens_the_ranging_and_gates_what_lies_beyond() -> None:
    device = host(wall(1.2))
    device.write(2, 24)
    ping = device.write(0, 0x51)
    device.now_ns = ping.end_ns + 65 * MS * 25 // 256
    assert device.read(2, 2) == bytes(2)


@pytest.mark.parametrize(("step", "gain"), [(0, 40), (1, 40), (8, 140), (16, 700), (200, 700)])
def test_the_gain_register_limits_what_is_heard(step: int, gain: int) -> None:
    needed = 20 * log10(700 / gain)
    for margin, heard in ((needed + 0.1, 200), (needed - 0.1, 0)):
        device = host(wall(2.0, margin))
        device.write(1, step)
        assert ranged(device) == heard


def test_a_power_cut_resets_gain_and_range() -> None:
    device = host(wall(2.0, margin=1.0))
    device.write(1, 0)
    device.write(2, 10)
    assert ranged(device) == 0
    device.power_cycle()
    assert ranged(device) == 200


def test_what_is_nearer_than_the_ring_down_reads_as_its_end() -> None:
    assert ranged(host(wall(0.02))) == 6


def test_it_takes_no_general_call() -> None:
    device = host(wall(1.0))
    device.address = 0
    assert device.write(0, 0x51).errno == ENXIO


def test_four_messages_give_it_another_address_for_good() -> None:
    device = host(wall(1.0))
    for value in (0xA0, 0xAA, 0xA5, 0xE2):
        device.write(0, value)
    assert device.take(1).errno == ENXIO
    device.address = 0x71
    device.power_cycle()
    assert ranged(device) == 100


@pytest.mark.parametrize("command", [0x00, 0x53, 0x56, 0x5C, 0xFF])
def test_a_command_that_it_does_not_know_starts_nothing(command: int) -> None:
    device = host(wall(1.0))
    device.write(0, command)
    assert device.take(1).errno == 0
