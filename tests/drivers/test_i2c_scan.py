"""Looking round an I2C bus: who is found, and that nobody is changed by it."""

from collections.abc import Sequence
from random import Random

from hypothesis import given
from hypothesis.strategies import integers
from pytest import mark

from echogrid.drivers.bus import NEVER_NS, I2cTransfer
from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.device import Line
from echogrid.drivers.errand import Errand
from echogrid.drivers.i2c_scan import OTHERS, RANGERS, Sighting, look_round
from echogrid.emulation.buses.i2c_bus import I2cBus
from echogrid.emulation.devices.i2c_chip import I2cChip
from echogrid.emulation.devices.i2cxl import I2cxlChip
from echogrid.emulation.devices.srf02 import Srf02Chip
from echogrid.emulation.devices.srf08 import Srf08Chip
from echogrid.emulation.devices.srf10 import Srf10Chip
from echogrid.emulation.wires.memory import MemoryPort
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulation import Simulation

from .i2c_bench import MS, room

SECOND = 1_000 * MS


class Multiplexer(I2cChip):
    """As a TCA9548A: its one register says which channels are on; any byte written goes there."""

    def __init__(self, channels: int, address: int = 0x70) -> None:
        super().__init__("multiplexer", address)
        self.channels = channels
        self.written: list[int] = []

    def acknowledges(self, now_ns: int) -> bool:
        return True

    def write(self, data: bytes, now_ns: int) -> None:
        self.written += data
        self.channels = data[-1]

    def read(self, count: int) -> bytes:
        return bytes((self.channels,)) * count

    def _next_ns(self) -> int:
        return NEVER_NS

    def _step(self, now_ns: int) -> None:
        pass

    def _power_up(self, now_ns: int) -> None:
        pass

    def _power_down(self) -> None:
        pass


def seen(*chips: I2cChip) -> Sequence[Sighting]:
    """All that is found on a bus with these."""
    clock = JumpingClock(SECOND)
    bus = I2cBus("i2c", 100_000, chips)
    bus.switch_on(clock.now_ns())
    errand = Errand[I2cTransfer, tuple[Sighting, ...]](
        lambda _: look_round(RANGERS + OTHERS), I2cTransfer(()), {}
    )
    pump = Pump(Line("i2c", [errand]), MemoryPort(bus, clock), clock, lambda readings: None)
    Simulation(clock, [pump], ReadingQueue()).sleep_until_ns(3 * SECOND)
    assert errand.done
    return errand.outcome or ()


@given(integers(0, 255), integers(0x70, 0x77))
def test_a_multiplexer_keeps_its_channels_and_is_taken_for_no_ranger(channels: int, address: int) -> None:
    multiplexer = Multiplexer(channels, address)
    (sighting,) = seen(multiplexer)
    assert (sighting.address, sighting.drivers) == (address, ())
    assert set(multiplexer.written) <= {channels}
    assert multiplexer.channels == channels


@given(integers(0, 255))
def test_an_srf08_may_be_in_any_light(light: int) -> None:
    sighting = Sighting(0x70, bytes((9, light, 0, 0, 0, 0)), True)
    assert "srf08" in sighting.drivers
    assert ("srf02" in sighting.drivers) == ("srf10" in sighting.drivers) == (light == 0x80)


@mark.parametrize(
    ("chip", "drivers"),
    [
        (Srf02Chip("two", room(1.0), Random(1)), ("srf02", "srf10", "srf08")),
        (Srf08Chip("eight", room(1.0), Random(1)), ("srf08",)),
        (Srf10Chip("ten", room(1.0), Random(1)), ("srf02", "srf10", "srf08")),
        (I2cxlChip("xl", room(1.0), Random(1)), ("i2cxl",)),
    ],
)
def test_rangers_are_told_by_their_registers(chip: I2cChip, drivers: tuple[str, ...]) -> None:
    (sighting,) = seen(chip)
    assert sighting.drivers == drivers


@mark.parametrize("pointer", range(36))
def test_a_ranger_is_found_wherever_its_last_reader_left_off(pointer: int) -> None:
    chip = Srf08Chip("eight", room(1.0), Random(1))
    chip.write(bytes((pointer,)), 0)
    (sighting,) = seen(chip)
    assert sighting.drivers == ("srf08",)


def test_an_empty_bus_has_nobody() -> None:
    assert seen() == ()
