"""An emulated Devantech SRF02 in its serial mode."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from random import Random
from typing import ClassVar

from echogrid.emulation.devices.devantech_serial import CENTIMETRE, INCH, OWN_SPEED, DevantechSerial
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

_MINIMUM, _TUNE_ANEW = 0x5F, 0x60
_TUNING_PINGS = 6


@dataclass(frozen=True, slots=True)
class Srf02SerialOptions:
    """What differs between chips of this kind."""

    address: int = 0
    """As it is delivered."""
    revision: int = 6
    first_minimum: float = 0.28
    """m within which it is deaf after power-up;"""
    minimum: float = 0.15
    """the same when it has tuned itself: 0.11 to 0.16 by the transducer."""
    speed_of_sound: float = OWN_SPEED
    """m/s, which the chip takes for centimetres and inches at any temperature."""

    def __post_init__(self) -> None:
        if self.address not in Srf02SerialSensor.addresses:
            raise ValueError(f"address {self.address} is not one of an SRF02 on a serial line (0 to 15)")
        if not 0 < self.minimum <= self.first_minimum:
            raise ValueError(f"minimum {self.minimum} is not between 0 and first_minimum")


class Srf02SerialSensor(DevantechSerial):
    """Its dead zone shrinks in its first pings."""

    addresses: ClassVar[range] = range(16)
    ranging_units: ClassVar[Mapping[int, float]] = {0x50: INCH, 0x51: CENTIMETRE, 0x52: 0.0}
    listening_units: ClassVar[Mapping[int, float]] = {0x56: INCH, 0x57: CENTIMETRE, 0x58: 0.0}

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: Srf02SerialOptions | None = None,
    ) -> None:
        self._options = options or Srf02SerialOptions()
        super().__init__(name, self._options.address, surroundings, random, bits_per_byte=11)
        self._revision = self._options.revision
        self._minimum = bytes(2)
        self._own_speed = self._options.speed_of_sound

    def _order(self, command: int, now_ns: int) -> None:
        if command == _MINIMUM:
            self.reply(self._minimum, now_ns)
        elif command == _TUNE_ANEW:
            self._pings = 0

    def _hear(self, echoes: Sequence[Echo]) -> None:
        self._minimum = self._in_unit(2 * self._deaf_within() / self._own_speed)
        super()._hear(echoes)

    def _forget(self) -> None:
        super()._forget()
        self._minimum = bytes(2)

    def _deaf_within(self) -> float:
        tuned = min(self._pings, _TUNING_PINGS) / _TUNING_PINGS
        return self._options.first_minimum + tuned * (self._options.minimum - self._options.first_minimum)
