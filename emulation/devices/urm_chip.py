"""What an emulated URM09 and URM13 have in common: registers, a thermometer, automatic ranging."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from random import Random
from typing import ClassVar, Protocol

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.i2c_ranger import I2cRanger
from echogrid.emulation.devices.sonar import first_heard
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

_ADDRESS = 0x00
_FIRST_ADDRESS, _LAST_ADDRESS = 0x08, 0x77
_MEASURE = 0x01
_NOTHING = 0xFFFF
_ZERO_CELSIUS_K = 273.15
_SPEED_AT_ZERO = 331.3
"""m/s in dry air."""


@dataclass(frozen=True, slots=True)
class Span:
    """What it hears in one of its ranges, and how long a ranging takes."""

    nearest: float
    """m."""
    farthest: float
    """m."""
    ranging_ns: int


class UrmOptions(Protocol):
    """What differs between parts of either."""

    @property
    def address(self) -> int:
        """7 bit."""
        ...

    @property
    def configuration(self) -> int:
        """The register of mode and range, when it is first switched on."""
        ...


def require_address(address: int) -> None:
    """Raise ValueError for an address that such a chip cannot have."""
    if not _FIRST_ADDRESS <= address <= _LAST_ADDRESS:
        raise ValueError(f"address {address:#x} is not one of a chip (0x08 to 0x77, 7 bit)")


class UrmChip(I2cRanger):
    """Acknowledges at any time: until a ranging is over it tells the one before.

    Its distances are true, because it measures the temperature. A new address is kept, and taken up with
    the next power-up. Commands that come while it ranges are passed over.
    """

    mute_while_ranging: ClassVar[bool] = False
    unmeasured: ClassVar[int] = _NOTHING
    """The distance registers at power-up."""

    def __init__(self, name: str, surroundings: Surroundings, random: Random, options: UrmOptions) -> None:
        super().__init__(name, options.address, surroundings, random)
        self._options = options
        self._kept_address = options.address
        self._configuration = options.configuration
        self._forget()

    def write(self, data: bytes, now_ns: int) -> None:
        """The register's number, and the values for it and those after it."""
        if not data:
            return
        self._pointer = data[0]
        for register, value in enumerate(data[1:], start=data[0]):
            if register == _ADDRESS:
                self._keep(value)
            else:
                self._put(register, value, now_ns)

    @abstractmethod
    def _put(self, register: int, value: int, now_ns: int) -> None:
        """Take a value for a register other than the address."""

    @abstractmethod
    def _image(self, distance: bytes, temperature: bytes) -> bytes:
        """The registers from 1 on."""

    @abstractmethod
    def _span(self) -> Span:
        """The range that it is set to."""

    @abstractmethod
    def _automatic(self) -> bool:
        """Whether it is set to range by itself, again and again."""

    def _configure(self, configuration: int, now_ns: int) -> None:
        """Take another mode and range."""
        self._configuration = configuration
        if self._automatic():
            self._range(now_ns)

    def _order(self, value: int, now_ns: int) -> None:
        """Take a value for the command register."""
        if value & _MEASURE:
            self._range(now_ns)

    def _range(self, now_ns: int) -> None:
        if not self.ranging(now_ns):
            self._begin(now_ns, self._span().ranging_ns, NEVER_NS)

    def _keep(self, address: int) -> None:
        if _FIRST_ADDRESS <= address <= _LAST_ADDRESS:
            self._kept_address = address

    def _registers(self, count: int) -> bytes:
        """So many registers from the one that was named."""
        distance = self._centimetres.to_bytes(2, "big")
        temperature = self._tenths().to_bytes(2, "big", signed=True)
        registers = bytes((self._kept_address,)) + self._image(distance, temperature)
        return registers[self._pointer : self._pointer + count].ljust(count, b"\0")

    def _tenths(self) -> int:
        """The temperature of the air in which sound is that quick, in 0.1 degrees Celsius."""
        warmth = (self.sonar.speed_of_sound / _SPEED_AT_ZERO) ** 2
        return round(10 * _ZERO_CELSIUS_K * (warmth - 1))

    def _hear(self, echoes: Sequence[Echo]) -> None:
        span = self._span()
        distance = first_heard(echoes, span.farthest, span.nearest)
        self._centimetres = _NOTHING if distance is None else round(100 * distance)
        if self._automatic():
            self._range(self._done_ns)

    def _power_up(self, now_ns: int) -> None:
        super()._power_up(now_ns)
        if self._automatic():
            self._range(now_ns)

    def _forget(self) -> None:
        self.address = self._kept_address
        self._pointer = 0
        self._centimetres = self.unmeasured
