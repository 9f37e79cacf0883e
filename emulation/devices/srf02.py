"""An emulated Devantech SRF02 in its I2C mode: one capsule, whose dead zone shrinks while it tunes itself."""

from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

from echogrid.emulation.devices.devantech import (
    CENTIMETRE,
    FULL_RANGING_NS,
    INCH,
    OWN_SPEED,
    UNITS,
    UNUSED,
    OneCapsuleChip,
    require_address,
)
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

_LISTEN = {0x56: INCH, 0x57: CENTIMETRE, 0x58: 0.0}
"""Commands for all of a ranging but the ping."""
_BURST, _TUNE_ANEW = 0x5C, 0x60
_TUNING_PINGS = 6


@dataclass(frozen=True, slots=True)
class Srf02Options:
    """What differs between chips of this kind."""

    address: int = 0x70
    """7 bit; as it is delivered."""
    revision: int = 6
    first_minimum: float = 0.28
    """m within which it is deaf after power-up;"""
    minimum: float = 0.15
    """the same when it has tuned itself: 0.11 to 0.16 by the transducer."""
    ranging_ns: int = FULL_RANGING_NS
    """For how long it ranges, and hears; a real one takes the 65 ms."""
    speed_of_sound: float = OWN_SPEED
    """m/s, which the chip takes for centimetres and inches at any temperature."""

    def __post_init__(self) -> None:
        require_address(self.address)
        if not 0 < self.minimum <= self.first_minimum:
            raise ValueError(f"minimum {self.minimum} is not between 0 and first_minimum")
        if self.ranging_ns <= 0:
            raise ValueError(f"ranging_ns {self.ranging_ns} is no time")


class Srf02Chip(OneCapsuleChip):
    """Its gain is fixed. It tells the minimum range which the last ranging had, in the unit of that one."""

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: Srf02Options = Srf02Options(),
    ) -> None:
        self._options = options
        super().__init__(name, options.address, surroundings, random, options.speed_of_sound)

    def _bank(self) -> bytes:
        return bytes((self._options.revision, UNUSED)) + self._range + self._minimum

    def _forget(self) -> None:
        super()._forget()
        self._range = self._minimum = bytes(2)
        self._silent = False
        self._pings = 0

    def _order(self, command: int, now_ns: int) -> None:
        if command in UNITS or command in _LISTEN:
            self._silent = command in _LISTEN
            self._unit = _LISTEN[command] if self._silent else UNITS[command]
            self._begin(now_ns, self._options.ranging_ns, self._options.ranging_ns, self._silent)
        elif command == _BURST:
            self.sonar.fire(now_ns)
        elif command == _TUNE_ANEW:
            self._pings = 0

    def _hear(self, echoes: Sequence[Echo]) -> None:
        """What came while it listened; a ping tunes it a little more."""
        deaf_s = 2 * self._deaf_within() / self._own_speed
        self._range = self._first(echoes, deaf_s, self._options.ranging_ns * 1e-9)
        self._minimum = self._in_unit(deaf_s)
        self._pings += not self._silent

    def _deaf_within(self) -> float:
        """m."""
        tuned = min(self._pings, _TUNING_PINGS) / _TUNING_PINGS
        return self._options.first_minimum + tuned * (self._options.minimum - self._options.first_minimum)
