"""An emulated Devantech SRF235: a 235 kHz pencil beam, quick and short of range."""

from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

from echogrid.emulation.devices.devantech import OWN_SPEED, UNITS, UNUSED, OneCapsuleChip, require_address
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

_RANGING_NS = 10_000_000
_BLANKING = 0.10
"""m."""


@dataclass(frozen=True, slots=True)
class Srf235Options:
    """What differs between chips of this kind."""

    address: int = 0x70
    """7 bit; as it is delivered."""
    revision: int = 3
    unit_mm: float = 10.0
    """The unit of command 0x51: centimetres, or millimetres: sources differ."""
    speed_of_sound: float = OWN_SPEED
    """m/s, which the chip takes for all units but microseconds at any temperature."""

    def __post_init__(self) -> None:
        require_address(self.address)
        if self.unit_mm <= 0:
            raise ValueError(f"unit_mm {self.unit_mm} is no unit")


class Srf235Chip(OneCapsuleChip):
    """Four registers, as the SRF10 has them, and no settings."""

    burst_s = 8 / 235e3

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: Srf235Options = Srf235Options(),
    ) -> None:
        super().__init__(name, options.address, surroundings, random, options.speed_of_sound)
        self._options = options
        self._units = {**UNITS, 0x51: options.unit_mm / 1000}

    def _bank(self) -> bytes:
        return bytes((self._options.revision, UNUSED)) + self._range

    def _forget(self) -> None:
        super()._forget()
        self._range = bytes(2)

    def _order(self, command: int, now_ns: int) -> None:
        if command in self._units:
            self._unit = self._units[command]
            self._begin(now_ns, _RANGING_NS, _RANGING_NS)

    def _hear(self, echoes: Sequence[Echo]) -> None:
        self._range = self._first(echoes, 2 * _BLANKING / self._own_speed, _RANGING_NS * 1e-9)
