"""An emulated DFRobot URM13 in its I2C mode: ranging on command or by itself, near or far."""

from dataclasses import dataclass

from echogrid.emulation.devices.urm_chip import Span, UrmChip, require_address

_PRODUCT, _VERSION = 0x02, 0x10
_CONFIGURATION, _COMMAND = 0x09, 0x0A
_PASSIVE, _SHORT = 0x04, 0x10
_KEPT_BITS = 0x17
"""Bits 0 and 1 are of the compensation, which here is always that of the own thermometer."""
_NEAR = Span(0.15, 1.5, 20_000_000)
_FAR = Span(0.40, 9.0, 95_000_000)
"""Up to 50 and 10 rangings a second, says the maker."""


@dataclass(frozen=True, slots=True)
class Urm13I2cOptions:
    """What differs between parts."""

    address: int = 0x12
    """7 bit."""
    configuration: int = 0x04
    """When it is first switched on: 0x04 it ranges on command, 0x10 near."""

    def __post_init__(self) -> None:
        require_address(self.address)
        if self.configuration & ~_KEPT_BITS:
            raise ValueError(f"configuration {self.configuration:#x} is none of a URM13")


class Urm13I2cChip(UrmChip):
    """Its configuration outlasts its power."""

    def _put(self, register: int, value: int, now_ns: int) -> None:
        if register == _CONFIGURATION:
            self._configure(value & _KEPT_BITS, now_ns)
        elif register == _COMMAND:
            self._order(value, now_ns)

    def _image(self, distance: bytes, temperature: bytes) -> bytes:
        """External temperature, command, noise and sensitivity read 0."""
        head = bytes((_PRODUCT, _VERSION)) + distance + temperature
        return head + bytes((0, 0, self._configuration, 0, 0, 0))

    def _span(self) -> Span:
        return _NEAR if self._configuration & _SHORT else _FAR

    def _automatic(self) -> bool:
        return not self._configuration & _PASSIVE
