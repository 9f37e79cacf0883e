from random import Random

import pytest

from echogrid.drivers.bus import I2cMessage, I2cResult, I2cTransfer
from echogrid.emulation.buses.i2c_bus import I2cBus
from echogrid.emulation.devices.srf08 import Srf08Chip, Srf08Options
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.errors import UnknownVerbError
from echogrid.emulation.scene import Echo

MS = 1_000_000
ENXIO = 6
SPEED = 343.0


def chip(*echoes: Echo, name: str = "front", speed: float = SPEED, address: int = 0x70) -> Srf08Chip:
    surroundings = Surroundings(lambda fire_ns: echoes, speed)
    return Srf08Chip(name, surroundings, Random(1), Srf08Options(address=address))


def wall(distance: float, margin: float = 40.0) -> Echo:
    return Echo(distance, margin, "wall")


class Host:
    """An I2C host which waits for each result."""

    def __init__(self, *chips: Srf08Chip) -> None:
        self.bus = I2cBus("i2c", 100_000, chips)
        self.bus.switch_on(0)
        self.now_ns = 0

    def transfer(self, *messages: I2cMessage) -> I2cResult:
        self.bus.send((I2cTransfer(messages),), self.now_ns)
        while not (results := self.bus.take(self.now_ns)):
            self.now_ns = self.bus.next_event_ns()
        return results[0]

    def write(self, *data: int, address: int = 0x70) -> I2cResult:
        return self.transfer(I2cMessage(address, bytes(data)))

    def read(self, register: int, count: int, address: int = 0x70) -> I2cResult:
        return self.transfer(I2cMessage(address, bytes((register,))), I2cMessage(address, read=count))

    def range(self, command: int = 0x51, address: int = 0x70) -> bytes:
        """The echo registers after a ranging."""
        self.write(0, command, address=address)
        self.now_ns += 300 * MS
        return self.read(2, 34, address).data


def echoes_of(registers: bytes) -> list[int]:
    values = [int.from_bytes(registers[at : at + 2], "big") for at in range(0, len(registers), 2)]
    return values[: values.index(0)] if 0 in values else values


def test_a_wall_at_three_metres_reads_as_the_bytes_01_2c_in_centimetres() -> None:
    assert Host(chip(wall(3.0))).range(0x51)[:4] == bytes.fromhex("012C0000")


@pytest.mark.parametrize(("command", "value"), [(0x50, 118), (0x51, 300), (0x52, 17493)])
def test_each_ranging_command_has_its_unit(command: int, value: int) -> None:
    assert echoes_of(Host(chip(wall(3.0))).range(command)) == [value]


def test_in_cold_air_microseconds_are_true_and_centimetres_are_not() -> None:
    assert echoes_of(Host(chip(wall(3.0), speed=325.0)).range(0x52)) == [round(6 / 325.0 * 1e6)]
    assert echoes_of(Host(chip(wall(3.0), speed=325.0)).range(0x51)) == [round(300 * 343 / 325)]


def test_revision_and_light_stand_before_the_echoes() -> None:
    host = Host(chip(wall(1.0)))
    host.range()
    assert host.read(0, 4).data == bytes((10, 90, 0, 100))


def test_seventeen_echoes_fill_the_registers_and_no_more() -> None:
    host = Host(chip(*(wall(0.5 + 0.25 * index) for index in range(20))))
    assert len(echoes_of(host.range())) == 17
    assert host.read(36, 2).data == b"\0\0"


def test_nothing_heard_is_all_zeros() -> None:
    assert Host(chip()).range() == bytes(34)


def test_while_ranging_it_does_not_acknowledge() -> None:
    host = Host(chip(wall(1.0)))
    ping = host.write(0, 0x51)
    host.now_ns = ping.end_ns + 64 * MS
    assert host.read(0, 1).errno == ENXIO
    host.now_ns = ping.end_ns + 65 * MS
    assert host.read(0, 1).errno == 0


def test_the_range_register_shortens_the_ranging_and_gates_what_lies_beyond() -> None:
    host = Host(chip(wall(0.9), wall(1.2)))
    host.write(2, 24)
    ping = host.write(0, 0x51)
    host.now_ns = ping.end_ns + 65 * MS * 25 // 256
    assert echoes_of(host.read(2, 34).data) == [90]


def test_at_the_least_gain_a_weak_echo_is_not_heard() -> None:
    host = Host(chip(wall(1.0, margin=21.0), wall(2.0, margin=20.0)))
    assert echoes_of(host.range()) == [100, 200]
    host.write(1, 0)
    assert echoes_of(host.range()) == [100]


def test_near_by_the_gain_is_still_rising() -> None:
    assert echoes_of(Host(chip(wall(0.1, margin=10.0))).range()) == []
    assert echoes_of(Host(chip(wall(0.4, margin=10.0))).range()) == [40]


def test_what_is_nearer_than_the_ring_down_reads_as_its_end() -> None:
    assert echoes_of(Host(chip(wall(0.01), wall(0.02), wall(1.0))).range()) == [3, 100]


def test_a_power_cut_resets_gain_and_range() -> None:
    device = chip(wall(2.0, margin=10.0))
    host = Host(device)
    host.write(1, 0)
    host.write(2, 10)
    assert echoes_of(host.range()) == []
    device.fault("off", host.now_ns, 100 * MS)
    assert host.read(0, 1).errno == ENXIO
    host.now_ns += 100 * MS
    assert host.read(2, 34).data == bytes(34)
    assert echoes_of(host.range()) == [200]


def test_a_general_call_fires_every_chip_at_once() -> None:
    host = Host(chip(wall(1.0)), chip(wall(2.0), name="left", address=0x71))
    assert host.write(0, 0x51, address=0).errno == 0
    assert host.read(0, 1, 0x70).errno == host.read(0, 1, 0x71).errno == ENXIO
    host.now_ns += 65 * MS
    assert echoes_of(host.read(2, 34, 0x70).data) == [100]
    assert echoes_of(host.read(2, 34, 0x71).data) == [200]


def test_nobody_at_an_address_is_not_an_acknowledge() -> None:
    result = Host(chip()).read(0, 1, 0x72)
    assert (result.errno, result.data) == (ENXIO, b"")


def test_a_byte_takes_nine_bits() -> None:
    result = Host(chip()).write(0, 0x51)
    assert result.end_ns - result.start_ns == 3 * 9 * 10_000


@pytest.mark.parametrize("verb", ["off", "unplug"])
def test_without_power_it_does_not_acknowledge_until_the_fault_is_cleared(verb: str) -> None:
    device = chip(wall(1.0))
    host = Host(device)
    device.fault(verb, host.now_ns)
    assert host.read(0, 1).errno == ENXIO
    device.clear(host.now_ns)
    assert echoes_of(host.range()) == [100]


def test_garbage_is_random_registers() -> None:
    device = chip(wall(1.0))
    host = Host(device)
    device.fault("garbage", 0)
    assert host.read(2, 34).data != host.read(2, 34).data


def test_a_delayed_chip_ranges_for_200_ms_more() -> None:
    device = chip(wall(1.0))
    host = Host(device)
    device.fault("delayed", 0)
    ping = host.write(0, 0x51)
    host.now_ns = ping.end_ns + 264 * MS
    assert host.read(0, 1).errno == ENXIO
    host.now_ns = ping.end_ns + 265 * MS
    assert host.read(0, 1).errno == 0


def test_an_unplugged_adapter_leaves_its_chips_without_power() -> None:
    host = Host(chip(wall(2.0)))
    host.write(2, 10)
    host.bus.fault("unplug", host.now_ns, MS)
    assert not host.bus.present
    host.now_ns += MS
    assert echoes_of(host.range()) == [200]


def test_an_unknown_verb_is_told_with_those_which_there_are() -> None:
    with pytest.raises(
        UnknownVerbError, match=r"front: no fault 'explode' \(there are: address_conflict, delayed, garbage"
    ):
        chip().fault("explode", 0)


def test_the_scene_is_asked_for_the_time_of_fire_when_it_has_listened() -> None:
    asked: list[int] = []

    def scene(fire_ns: int) -> tuple[Echo, ...]:
        asked.append(fire_ns)
        return ()

    host = Host(Srf08Chip("front", Surroundings(scene, SPEED), Random(1)))
    ping = host.write(0, 0x51)
    host.now_ns += 65 * MS
    host.read(0, 1)
    assert asked == [ping.end_ns]


def change_address(host: Host, *values: int, address: int = 0x70) -> None:
    for value in values:
        host.write(0, value, address=address)


def test_four_messages_in_order_give_it_another_address_for_good() -> None:
    device = chip(wall(1.0))
    host = Host(device)
    change_address(host, 0xA0, 0xAA, 0xA5, 0xF2)
    assert host.read(0, 1, 0x70).errno == ENXIO
    assert echoes_of(host.range(address=0x79)) == [100]
    device.fault("off", host.now_ns, MS)
    host.now_ns += 2 * MS
    assert host.read(0, 1, 0x79).errno == 0


@pytest.mark.parametrize(
    "values",
    [
        (0xA0, 0xA5, 0xAA, 0xF2),
        (0xA0, 0xAA, 0x51, 0xA5, 0xF2),
        (0xAA, 0xA5, 0xF2),
        (0xA0, 0xAA, 0xA5, 0xF3),
        (0xA0, 0xAA, 0xA5, 0xD0),
        (0xA0, 0xAA, 0xA5, 0x52, 0xF2),
    ],
)
def test_any_other_sequence_leaves_the_address_as_it_is(values: tuple[int, ...]) -> None:
    host = Host(chip())
    for value in values:
        host.write(0, value)
        host.now_ns += 65 * MS
    assert host.read(0, 1, 0x70).errno == 0


def test_a_sequence_begun_again_counts_from_its_second_beginning() -> None:
    host = Host(chip())
    change_address(host, 0xA0, 0xAA, 0xA0, 0xAA, 0xA5, 0xE4)
    assert host.read(0, 1, 0x72).errno == 0


@pytest.mark.parametrize("between", [(0,), (1, 31), (0, 0xAA, 0xA5)])
def test_no_other_message_may_come_in_between(between: tuple[int, ...]) -> None:
    host = Host(chip())
    host.write(0, 0xA0)
    host.write(*between)
    change_address(host, 0xAA, 0xA5, 0xF2)
    assert host.read(0, 1, 0x70).errno == 0


def test_a_read_in_between_breaks_the_sequence() -> None:
    host = Host(chip())
    change_address(host, 0xA0, 0xAA, 0xA5)
    host.transfer(I2cMessage(0x70, read=1))
    host.write(0, 0xF2)
    assert host.read(0, 1, 0x70).errno == 0


def test_a_loss_of_power_breaks_the_sequence() -> None:
    device = chip()
    host = Host(device)
    change_address(host, 0xA0, 0xAA, 0xA5)
    device.fault("off", host.now_ns, MS)
    host.now_ns += 2 * MS
    host.write(0, 0xF2)
    assert host.read(0, 1, 0x70).errno == 0


def test_two_at_one_address_pull_each_other_s_bits_down() -> None:
    host = Host(chip(wall(1.0)), chip(wall(1.1), name="twin"))
    assert echoes_of(host.range(0x52)) == [5831 & 6414]


@pytest.mark.parametrize("address", [0x6F, 0x80, 0xE0])
def test_an_address_of_another_make_is_refused(address: int) -> None:
    with pytest.raises(ValueError, match="is not one of a Devantech ranger"):
        Srf08Options(address=address)
