"""An emulated Devantech SRF08: ranging on command, seventeen echoes, silent while it listens."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import log10
from random import Random

from echogrid.emulation.devices.i2c_ranger import I2cRanger
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

GAINS = (
    *(94, 97, 100, 103, 107, 110, 114, 118, 123, 128, 133, 139, 145, 152, 159, 168),
    *(177, 187, 199, 212, 227, 245, 265, 288, 317, 352, 395, 450, 524, 626, 777, 1025),
)
"""Amplification by the value of the gain register."""

_COMMAND, _GAIN, _RANGE = 0, 1, 2
_ECHOES = 17
_FULL_RANGING_NS = 65_000_000
_RANGE_STEP = 0.043
"""m for one step of the range register."""
_GAIN_STEP_S = 70e-6
_BLANKING = 0.03
"""m."""
_BURST_S = 200e-6
"""Eight cycles of 40 kHz."""
_US = 0x52
_UNITS = {0x50: 0.0254, 0x51: 0.01}
"""m for the unit of a ranging command; 0x52 gives the time of flight itself."""


@dataclass(frozen=True, slots=True)
class Srf08Options:
    """What differs between chips of this kind."""

    address: int = 0x70
    """7 bit."""
    revision: int = 10
    light: int = 128
    speed_of_sound: float = 343.0
    """m/s, which the chip takes for centimetres, inches and its range gate at any temperature."""

    def __post_init__(self) -> None:
        if not 0x08 <= self.address <= 0x7F:
            raise ValueError(f"address {self.address:#x} is not one of a chip (0x08 to 0x7f, 7 bit)")


class Srf08Chip(I2cRanger):
    """Does not acknowledge while ranging. Its gain and range registers are lost with its power.

    What it hears in the blanking distance runs together with the transducer's ring-down: one first echo
    at that distance. Echoes nearer to each other than the burst is long run together into the first.
    """

    takes_general_call = True

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: Srf08Options = Srf08Options(),
    ) -> None:
        super().__init__(name, options.address, surroundings, random)
        self._options = options
        self._forget()

    def write(self, data: bytes, now_ns: int) -> None:
        """The register's number, and the values for it and those after it."""
        if not data:
            return
        self._pointer = data[0]
        for register, value in enumerate(data[1:], start=data[0]):
            if register == _COMMAND:
                self._order(value, now_ns)
            elif register == _GAIN:
                self._gain = min(value, len(GAINS) - 1)
            elif register == _RANGE:
                self._range = value

    def _registers(self, count: int) -> bytes:
        """So many registers from the one that was named."""
        registers = bytes((self._options.revision, self._light)) + self._echo_registers
        wanted = registers[self._pointer : self._pointer + count]
        return wanted.ljust(count, b"\0")

    def _forget(self) -> None:
        self._gain = len(GAINS) - 1
        self._range = 255
        self._pointer = 0
        self._light = 0
        self._echo_registers = bytes(2 * _ECHOES)
        self._command = 0

    def _order(self, command: int, now_ns: int) -> None:
        if command not in _UNITS and command != _US:
            return
        self._command = command
        self._begin(now_ns, _FULL_RANGING_NS * (self._range + 1) // 256, round(self._gate_s() * 1e9))

    def _hear(self, echoes: Sequence[Echo]) -> None:
        self._light = self._options.light
        values = [self._value(flight_s) for flight_s in self._flights(echoes)]
        registers = b"".join(min(value, 0xFFFF).to_bytes(2, "big") for value in values[:_ECHOES])
        self._echo_registers = registers.ljust(2 * _ECHOES, b"\0")

    def _gate_s(self) -> float:
        return 2 * (self._range + 1) * _RANGE_STEP / self._options.speed_of_sound

    def _flights(self, echoes: Sequence[Echo]) -> list[float]:
        """The times of flight (s) that it tells apart, by its gain, its range gate and its burst."""
        gate_s = self._gate_s()
        blanking_s = 2 * _BLANKING / self._options.speed_of_sound
        flights: list[float] = []
        for echo in echoes:
            flight_s = max(2 * echo.distance / self.sonar.speed_of_sound, blanking_s)
            apart = not flights or flight_s - flights[-1] > _BURST_S
            if apart and flight_s <= gate_s and echo.margin + self._gain_db(flight_s) >= 0:
                flights.append(flight_s)
        return flights

    def _gain_db(self, flight_s: float) -> float:
        """Amplification at that time relative to the most: it rises a step every 70 us after the ping."""
        step = min(self._gain, int(flight_s / _GAIN_STEP_S))
        return 20 * log10(GAINS[step] / GAINS[-1])

    def _value(self, flight_s: float) -> int:
        if self._command == _US:
            return round(flight_s * 1e6)
        return round(flight_s * self._options.speed_of_sound / 2 / _UNITS[self._command])
