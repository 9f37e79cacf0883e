"""Which rangers are on an I2C bus, by what their registers say: nothing is commanded, and nothing changed.

To read a register its number has to be written. Where rangers are, so are multiplexers (PCA954x, TCA954x),
and these take any byte that is written for the channels to switch on. So nothing is written there before it
has been read as it is: a multiplexer says its channels, in every byte the same.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from echogrid.drivers.bus import I2cTransfer
from echogrid.drivers.course import Course
from echogrid.drivers.devantech import FIRST_ADDRESS, LAST_ADDRESS, UNUSED
from echogrid.drivers.i2c_chip import Chip

LOOKED_AT = 6
"""Registers from 0 on."""
DEVANTECH = range(FIRST_ADDRESS, LAST_ADDRESS + 1)
URM09, URM13, RCWL9620 = 0x11, 0x12, 0x57
RANGERS = (URM09, URM13, RCWL9620, *DEVANTECH)
"""Where rangers are: only there a register is named, which writes a byte."""
OTHERS = tuple(address for address in range(0x08, 0x78) if address not in RANGERS)
SECOND_LOOK = 2
"""The register from which it is read once more. Not 1: that byte fires an RCWL-9620."""
RANGING_NS = 80_000_000
"""No ranging lasts longer."""


@dataclass(frozen=True, slots=True)
class Sighting:
    """Somebody who acknowledges."""

    address: int
    """7 bit."""
    registers: bytes
    """0 and following; nothing if no register was named."""
    has_registers: bool
    """Whether the register that is named makes a difference."""

    @property
    def drivers(self) -> tuple[str, ...]:
        """Those which it may be, by what it says."""
        return tuple(name for name, fits in _FITS.items() if self.registers and fits(self))


def look_round(addresses: tuple[int, ...]) -> Course[I2cTransfer, tuple[Sighting, ...]]:
    """Everybody who acknowledges at one of the addresses."""
    found: list[Sighting] = []
    for address in addresses:
        sighting = yield from _look(address)
        if sighting is not None:
            found.append(sighting)
    return tuple(found)


def look_twice(now_ns: Callable[[], int]) -> Course[I2cTransfer, tuple[Sighting, ...]]:
    """Everybody on the bus; where rangers are it looks again later, for one that ranges does not answer."""
    first = yield from look_round(RANGERS + OTHERS)
    yield now_ns() + RANGING_NS
    silent = tuple(address for address in DEVANTECH if all(address != each.address for each in first))
    return first + (yield from look_round(silent))


def _look(address: int) -> Course[I2cTransfer, Sighting | None]:
    chip, unknown = Chip(address), Sighting(address, b"", False)
    if address not in RANGERS:
        return unknown if (yield from chip.take(1)) else None
    if address in DEVANTECH:
        unasked = yield from chip.take(LOOKED_AT)
        if not unasked:
            return None
        if len(set(unasked)) == 1 and any(unasked):
            return unknown
    registers = yield from chip.read(0, LOOKED_AT)  # Of a multiplexer it switches off what is off already.
    if not registers:
        return None
    if not any(registers):
        return unknown
    second = yield from chip.read(SECOND_LOOK, 2)
    told = registers[SECOND_LOOK : SECOND_LOOK + 2]
    return Sighting(address, registers, second == told and second != registers[:2])


def _is_devantech(sighting: Sighting) -> bool:
    """Any of them may be an SRF08: its light may be just what is read in the others' unused register."""
    return sighting.address in DEVANTECH and sighting.has_registers and _revised(sighting)


def _is_srf02_or_srf10(sighting: Sighting) -> bool:
    return _is_devantech(sighting) and sighting.registers[1] == UNUSED


def _revised(sighting: Sighting) -> bool:
    return sighting.registers[0] not in (0x00, 0xFF)


def _urm(identity: int) -> Callable[[Sighting], bool]:
    """It tells its own address, and which part it is."""

    def fits(sighting: Sighting) -> bool:
        return sighting.registers[:2] == bytes((sighting.address, identity))

    return fits


_FITS: Mapping[str, Callable[[Sighting], bool]] = {
    "srf02": _is_srf02_or_srf10,
    "srf10": _is_srf02_or_srf10,
    "srf08": _is_devantech,
    "i2cxl": lambda sighting: sighting.address in DEVANTECH and not sighting.has_registers,
    "urm09": _urm(0x01),
    "urm13-i2c": _urm(0x02),
    "rcwl-9620": lambda sighting: sighting.address == RCWL9620 and not sighting.has_registers,
}
