"""An emulated MaxBotix I2CXL-MaxSonar: no registers, a byte fires it, two bytes are the range."""

from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

from echogrid.emulation.devices.i2c_ranger import I2cRanger
from echogrid.emulation.devices.sonar import first_heard
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

_RANGE = b"\x51"
_UNLOCK = b"\xaa\xa5"
_REFUSED = (0, 80, 164, 170)
"""8-bit addresses that it does not take."""
_PART_INFO = b"\x01\x0a"
"""What these bytes mean is not published. Taken for a range they are 266 cm, so that the mistake shows."""
_REACH_CM = 765


@dataclass(frozen=True, slots=True)
class I2cxlOptions:
    """What differs between parts."""

    address: int = 0x70
    """7 bit."""
    minimum_cm: int = 20
    """What it says of all that is nearer."""
    no_echo_cm: int = _REACH_CM
    """What it says when it hears nothing."""
    ranging_ns: int = 65_000_000
    """How long it ranges, and so how far it hears; 15 rangings a second, says the data sheet."""
    speed_of_sound: float = 344.8
    """m/s, which it takes for its centimetres at any temperature: 58 us there and back."""

    def __post_init__(self) -> None:
        if not 0x08 <= self.address <= 0x7F:
            raise ValueError(f"address {self.address:#x} is not one of a chip (0x08 to 0x7f, 7 bit)")
        if self.ranging_ns <= 0:
            raise ValueError(f"ranging_ns {self.ranging_ns} must be above 0")


class I2cxlChip(I2cRanger):
    """Does not acknowledge while ranging. Its address lasts; its last range is lost with its power."""

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: I2cxlOptions = I2cxlOptions(),
    ) -> None:
        super().__init__(name, options.address, surroundings, random)
        self._options = options
        self._forget()

    def write(self, data: bytes, now_ns: int) -> None:
        """The command to range, or a new address behind its two keys."""
        if data == _RANGE:
            self._begin(now_ns, self._options.ranging_ns, self._options.ranging_ns)
        elif data[:2] == _UNLOCK and len(data) == 3:
            self._move(data[2] & 0xFE)

    def _move(self, address: int) -> None:
        if address not in _REFUSED:
            self.address = address >> 1

    def _registers(self, count: int) -> bytes:
        """The range; nobody drives the bus after it."""
        return self._range[:count].ljust(count, b"\xff")

    def _forget(self) -> None:
        self._range = _PART_INFO

    def _hear(self, echoes: Sequence[Echo]) -> None:
        listened = self.sonar.speed_of_sound * self._options.ranging_ns * 1e-9 / 2
        self._range = self._centimetres(first_heard(echoes, listened)).to_bytes(2, "big")

    def _centimetres(self, distance: float | None) -> int:
        if distance is None:
            return self._options.no_echo_cm
        own = round(100 * distance * self._options.speed_of_sound / self.sonar.speed_of_sound)
        return max(own, self._options.minimum_cm) if own < _REACH_CM else self._options.no_echo_cm
