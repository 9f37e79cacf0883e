"""An emulated DFRobot URM09: ranging on command or by itself, in one of three ranges."""

from dataclasses import dataclass
from typing import ClassVar

from echogrid.emulation.devices.urm_chip import Span, UrmChip, require_address

_PRODUCT, _VERSION = 0x01, 0x10
_CONFIGURATION, _COMMAND = 0x07, 0x08
_AUTOMATIC = 0x80
_SPAN_BITS = 0x30
_SPANS = {
    0x00: Span(0.02, 1.5, 20_000_000),
    0x10: Span(0.02, 3.0, 50_000_000),
    0x20: Span(0.02, 5.0, 90_000_000),
}
"""50 rangings a second at most, says the maker, who waits 100 ms in any range; between them, a guess."""


@dataclass(frozen=True, slots=True)
class Urm09Options:
    """What differs between parts."""

    address: int = 0x11
    """7 bit."""
    configuration: int = 0x00
    """At power-up: 0x80 it ranges by itself, 0x00, 0x10, 0x20: 1.5, 3 and 5 m."""

    def __post_init__(self) -> None:
        require_address(self.address)
        if self.configuration & ~(_AUTOMATIC | _SPAN_BITS) or self.configuration & _SPAN_BITS not in _SPANS:
            raise ValueError(f"configuration {self.configuration:#x} is none of a URM09")


class Urm09Chip(UrmChip):
    """Its configuration is lost with its power (a guess)."""

    unmeasured: ClassVar[int] = 0

    def _put(self, register: int, value: int, now_ns: int) -> None:
        if register == _CONFIGURATION and value & _SPAN_BITS in _SPANS:
            self._configure(value & (_AUTOMATIC | _SPAN_BITS), now_ns)
        elif register == _COMMAND:
            self._order(value, now_ns)

    def _image(self, distance: bytes, temperature: bytes) -> bytes:
        return bytes((_PRODUCT, _VERSION)) + distance + temperature + bytes((self._configuration, 0))

    def _span(self) -> Span:
        return _SPANS[self._configuration & _SPAN_BITS]

    def _automatic(self) -> bool:
        return bool(self._configuration & _AUTOMATIC)

    def _forget(self) -> None:
        super()._forget()
        self._configuration = self._options.configuration
