"""An emulated DFRobot URM37: it ranges when its distance is asked for, and replies with that."""

from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

from echogrid.emulation.devices.serial_ranger import SerialRanger
from echogrid.emulation.devices.sonar import first_heard
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

_BAUD = 9600
_TEMPERATURE, _DISTANCE = 0x11, 0x22
_LENGTH = 4
_GAP_BYTES = 5
"""After so many bytes' time without one a command begins anew: unknown, a guess."""
_ZERO_CELSIUS_K = 273.15
_SPEED_AT_ZERO = 331.3
"""m/s in dry air."""


@dataclass(frozen=True, slots=True)
class Urm37Options:
    """What differs between versions."""

    unit_mm: float = 10.0
    reach: float = 8.0
    """m."""
    nearest: float = 0.02
    """m: what is nearer reads as that."""
    no_echo: int = 0xFFFF
    """What it says when it hears nothing."""
    ranging_ns: int = 50_000_000
    """From the command to the reply: unknown; the maker waits for 75 ms."""


class Urm37Sensor(SerialRanger):
    """Takes no command while it ranges. It corrects for the temperature, so its distances are true."""

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: Urm37Options = Urm37Options(),
    ) -> None:
        super().__init__(name, _BAUD, surroundings, random)
        self._options = options
        self._gap_ns = _GAP_BYTES * self.bits_per_byte * 1_000_000_000 // _BAUD
        self._command = bytearray()
        self._received_ns = 0

    def receive(self, data: bytes, now_ns: int) -> None:
        """Take commands of four bytes; one with a wrong sum is none."""
        if now_ns - self._received_ns > self._gap_ns:
            self._command.clear()
        self._received_ns = now_ns
        for byte in data:
            self._command.append(byte)
            if len(self._command) == _LENGTH:
                command = bytes(self._command)
                self._command.clear()
                if command == _summed(*command[:3]) and not self.ranging(now_ns):
                    self._obey(command[0], now_ns)

    def _obey(self, command: int, now_ns: int) -> None:
        if command == _DISTANCE:
            self._begin(now_ns, self._options.ranging_ns, self._options.ranging_ns)
        elif command == _TEMPERATURE:
            self.reply(_summed(_TEMPERATURE, *divmod(self._tenths_celsius() & 0xFFFF, 256)), now_ns)

    def _hear(self, echoes: Sequence[Echo]) -> None:
        distance = first_heard(echoes, self._options.reach)
        self.reply(_summed(_DISTANCE, *divmod(self._counts(distance), 256)), self._done_ns)

    def _counts(self, distance: float | None) -> int:
        if distance is None:
            return self._options.no_echo
        return round(max(distance, self._options.nearest) * 1000 / self._options.unit_mm)

    def _tenths_celsius(self) -> int:
        """Of the world's air, by its speed of sound."""
        celsius = ((self.sonar.speed_of_sound / _SPEED_AT_ZERO) ** 2 - 1) * _ZERO_CELSIUS_K
        return round(10 * celsius)

    def _forget(self) -> None:
        self._command.clear()


def _summed(command: int, high: int, low: int) -> bytes:
    return bytes((command, high, low, (command + high + low) & 0xFF))
