"""What Devantech's emulated rangers on I2C share: commands, units, gain and range, the address."""

from abc import abstractmethod
from collections.abc import Sequence
from math import log10
from random import Random
from typing import ClassVar

from echogrid.emulation.devices.i2c_ranger import I2cRanger
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

INCH, CENTIMETRE = 0.0254, 0.01
UNITS = {0x50: INCH, 0x51: CENTIMETRE, 0x52: 0.0}
"""m for the unit of a ranging command; 0: it gives the time of flight itself, in microseconds."""
UNUSED = 0x80
"""What register 1 reads where nothing is behind it."""
OWN_SPEED = 343.0
"""m/s, which the chips take for centimetres, inches and range gates at any temperature."""
FULL_RANGING_NS = 65_000_000

_COMMAND, _GAIN, _RANGE = 0, 1, 2
_MOVE = (0xA0, 0xAA, 0xA5)
"""The commands behind which the next one is taken for an address (8 bit)."""
_ADDRESSES = range(0xE0, 0x100, 2)
_RANGE_STEP = 0.043
"""m for one step of the range register."""
_GAIN_STEP_S = 70e-6
_BURST_S = 200e-6
"""Eight cycles of 40 kHz."""


def require_address(address: int) -> None:
    """Raise ValueError for an address (7 bit) that these chips can't have."""
    if 2 * address not in _ADDRESSES:
        raise ValueError(f"address {address:#x} is not one of a Devantech ranger (0x70 to 0x7f, 7 bit)")


class DevantechChip(I2cRanger):
    """Ranges when a command is written to register 0, and does not acknowledge until that is over.

    What is written to no register in particular changes nothing; what is read where no register is, is zero.
    """

    _moved: int
    """How many messages have come of those which give it another address."""

    def __init__(
        self, name: str, address: int, surroundings: Surroundings, random: Random, own_speed: float
    ) -> None:
        super().__init__(name, address, surroundings, random)
        self._own_speed = own_speed
        self._forget()

    def write(self, data: bytes, now_ns: int) -> None:
        """The register's number, and the values for it and those after it."""
        self._move(data)
        if not data:
            return
        self._pointer = data[0]
        for register, value in enumerate(data[1:], start=data[0]):
            if register == _COMMAND:
                self._order(value, now_ns)
            else:
                self._set(register, value)

    def _move(self, data: bytes) -> None:
        """Four messages to the command register and nothing in between give it another address, for good."""
        if self._moved == len(_MOVE):
            if len(data) == 2 and data[0] == _COMMAND and data[1] in _ADDRESSES:
                self.address = data[1] >> 1
            self._moved = 0
        elif data == bytes((_COMMAND, _MOVE[self._moved])):
            self._moved += 1
        else:
            self._moved = int(data == bytes((_COMMAND, _MOVE[0])))

    def _registers(self, count: int) -> bytes:
        """So many registers from the one that was named."""
        self._moved = 0
        return self._bank()[self._pointer : self._pointer + count].ljust(count, b"\0")

    def _forget(self) -> None:
        self._pointer = 0
        self._moved = 0
        self._unit = 0.0

    def _in_unit(self, flight_s: float) -> bytes:
        """A time of flight in the unit of the last ranging, as two registers."""
        value = flight_s * 1e6
        if self._unit:
            value = flight_s * self._own_speed / 2 / self._unit
        return min(round(value), 0xFFFF).to_bytes(2, "big")

    def _set(self, register: int, value: int) -> None:
        """Take the value of another register than that of commands; a chip adds those which it has."""

    @abstractmethod
    def _order(self, command: int, now_ns: int) -> None:
        """Do what it is told."""

    @abstractmethod
    def _bank(self) -> bytes:
        """All registers."""


class OneCapsuleChip(DevantechChip):
    """Sends and listens with the same transducer: while that rings, it is deaf.

    A sound that is still there when it begins to hear reads as from just then; one that has gone is missed.
    """

    burst_s: ClassVar[float] = _BURST_S

    def _first(self, echoes: Sequence[Echo], deaf_s: float, listens_s: float) -> bytes:
        """The first sound that is heard after the ringing, in two registers; zero: there is none."""
        heard = (2 * echo.distance / self.sonar.speed_of_sound for echo in echoes if echo.margin >= 0)
        times = (max(at_s, deaf_s) for at_s in heard if deaf_s - self.burst_s < at_s <= listens_s)
        return self._in_unit(next(times, 0.0))


class GatedChip(DevantechChip):
    """Has a gain that rises from ping to limit, and a range gate; both registers are lost with the power.

    What it hears in the blanking distance runs together with the transducer's ring-down: one first echo
    at that distance. Echoes nearer to each other than the burst is long run together into the first.
    """

    gains: ClassVar[tuple[int, ...]]
    """Amplification by the value of the gain register."""
    blanking: ClassVar[float]
    """m."""
    most_echoes: ClassVar[int]

    def _set(self, register: int, value: int) -> None:
        if register == _GAIN:
            self._gain = min(value, len(self.gains) - 1)
        elif register == _RANGE:
            self._range = value

    def _forget(self) -> None:
        super()._forget()
        self._gain = len(self.gains) - 1
        self._range = 255
        self._echoes = bytes(2 * self.most_echoes)

    def _order(self, command: int, now_ns: int) -> None:
        if command in UNITS:
            self._unit = UNITS[command]
            lasts_ns = FULL_RANGING_NS * (self._range + 1) // 256
            self._begin(now_ns, lasts_ns, round(self._gate_s() * 1e9))

    def _hear(self, echoes: Sequence[Echo]) -> None:
        values = [self._in_unit(flight_s) for flight_s in self._flights(echoes)]
        self._echoes = b"".join(values[: self.most_echoes]).ljust(2 * self.most_echoes, b"\0")

    def _gate_s(self) -> float:
        return 2 * (self._range + 1) * _RANGE_STEP / self._own_speed

    def _flights(self, echoes: Sequence[Echo]) -> list[float]:
        """The times of flight (s) that it tells apart, by its gain, its range gate and its burst."""
        gate_s = self._gate_s()
        blanking_s = 2 * self.blanking / self._own_speed
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
        return 20 * log10(self.gains[step] / self.gains[-1])
