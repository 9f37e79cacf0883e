"""Emulated DFRobot URM12, URM13, URM14 and URM15: rangers that are Modbus slaves."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt
from random import Random
from typing import ClassVar

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.modbus_slave import (
    ILLEGAL_ADDRESS,
    ILLEGAL_VALUE,
    PARITIES,
    ModbusSlave,
    SlaveOptions,
)
from echogrid.emulation.devices.sonar import RANGING_VERBS, Sonar
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.faults import Verb

_PRODUCT, _VERSION, _ADDRESS, _BAUD, _FORMAT, _DISTANCE, _INSIDE, _OUTSIDE, _CONTROL = range(9)
"""The registers."""
_VERSION_WORD = 0x0010
_BAUDS = {2400: 1, 9600: 3, 14_400: 4, 19_200: 5, 38_400: 6, 57_600: 7, 115_200: 8}
_STOPS = {1: 1, 2: 3}
_TEMPERATURE_OUTSIDE, _UNCORRECTED, _PASSIVE, _TRIGGER, _SHORT = 1, 2, 4, 8, 16
"""Bits of the control register."""
_ASSUMED_CELSIUS = 20.0
"""What it reckons with uncorrected: unknown, a guess."""
_ZERO_CELSIUS_K = 273.15
_SPEED_AT_ZERO = 331.3
"""m/s in dry air."""


@dataclass(frozen=True, slots=True)
class Span:
    """One of the ranges that it can be set to."""

    farthest: float
    """m."""
    ranging_ns: int
    """From the command to the distance: the shortest period in its data sheet."""


@dataclass(frozen=True, slots=True)
class Part:
    """What tells one model from another."""

    product: int
    nothing: int
    """The distance register at power-up, and when nothing was heard."""
    span: Span
    short: Span | None = None
    """With the short-range bit set."""


@dataclass(frozen=True, slots=True)
class UrmOptions(SlaveOptions):
    """What differs between parts of each model."""

    baud: int = 19_200
    control: int = _PASSIVE
    """The control register when it is first switched on; it is kept without power."""
    clears_trigger: int = 1
    """0: the trigger bit stays as it was written."""
    unit_mm: float = 1.0
    """Of the distance register."""

    def __post_init__(self) -> None:
        SlaveOptions.__post_init__(self)
        if self.baud not in _BAUDS:
            raise ValueError(f"baud {self.baud} is none of {', '.join(map(str, _BAUDS))}")


class UrmSensor(ModbusSlave):
    """Ranges on command, or by itself without the passive bit.

    Until a ranging is over it tells the one before. A new address is kept, and taken up with the next
    power-up. A new baud or format is kept and read back, but never taken up: its line can't change.
    """

    part: ClassVar[Part]

    def __init__(self, name: str, surroundings: Surroundings, random: Random, options: UrmOptions) -> None:
        super().__init__(name, options, random)
        self._sonar = Sonar(surroundings, self.faults, random)
        self._options = options
        self._kept = {
            _ADDRESS: options.address,
            _BAUD: _BAUDS[options.baud],
            _FORMAT: PARITIES.index(options.parity) << 8 | _STOPS[options.stop_bits],
            _CONTROL: options.control & ~_TRIGGER,
        }
        self._done_ns = NEVER_NS
        self._forget()

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), **RANGING_VERBS}

    def _power_up(self, now_ns: int) -> None:
        super()._power_up(now_ns)
        self.address = self._kept[_ADDRESS]
        self._forget()
        if not self._kept[_CONTROL] & _PASSIVE:
            self._range(now_ns)

    def _power_down(self) -> None:
        super()._power_down()
        self._done_ns = NEVER_NS

    def _next_ns(self) -> int:
        return min(super()._next_ns(), self._done_ns)

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._done_ns:
            self._hear(now_ns)
        super()._step(now_ns)

    def _word(self, register: int) -> int | None:
        fixed = {
            _PRODUCT: self.part.product,
            _VERSION: _VERSION_WORD,
            _DISTANCE: self._counts,
            _INSIDE: round(10 * self._celsius()) & 0xFFFF,
            _OUTSIDE: self._outside,
        }
        return (fixed | self._kept | {_CONTROL: self._kept[_CONTROL] | self._trigger}).get(register)

    def _write(self, register: int, word: int, now_ns: int) -> int:
        if register == _CONTROL:
            self._steer(word, now_ns)
        elif register == _OUTSIDE:
            self._outside = word
        elif register in (_BAUD, _FORMAT):
            self._kept[register] = word
        elif register == _ADDRESS:
            if not 1 <= word <= 247:
                return ILLEGAL_VALUE
            self._kept[_ADDRESS] = word
        else:
            return ILLEGAL_ADDRESS
        return 0

    def _steer(self, word: int, now_ns: int) -> None:
        """Take the control register."""
        self._kept[_CONTROL] = word & ~_TRIGGER
        self._trigger = word & _TRIGGER
        if self._done_ns == NEVER_NS and (self._trigger or not word & _PASSIVE):
            self._range(now_ns)

    def _range(self, now_ns: int) -> None:
        self._sonar.fire(now_ns)
        self._done_ns = now_ns + self._span().ranging_ns * self._sonar.slowness

    def _hear(self, now_ns: int) -> None:
        """End a ranging."""
        self._done_ns = NEVER_NS
        distance = self._sonar.first(self._span().farthest)
        self._counts = self.part.nothing if distance is None else self._counted(distance)
        if self._options.clears_trigger:
            self._trigger = 0
        if not self._kept[_CONTROL] & _PASSIVE:
            self._range(now_ns)

    def _counted(self, distance: float) -> int:
        reckoned = distance * _speed(self._believed()) / self._sonar.speed_of_sound
        return max(1, round(1000 * reckoned / self._options.unit_mm))

    def _believed(self) -> float:
        """The temperature (degrees Celsius) with which it reckons."""
        if self._kept[_CONTROL] & _UNCORRECTED:
            return _ASSUMED_CELSIUS
        if self._kept[_CONTROL] & _TEMPERATURE_OUTSIDE:
            return (self._outside - (self._outside >> 15 << 16)) / 10
        return self._celsius()

    def _celsius(self) -> float:
        """The temperature of the air in which sound is that quick."""
        return _ZERO_CELSIUS_K * ((self._sonar.speed_of_sound / _SPEED_AT_ZERO) ** 2 - 1)

    def _span(self) -> Span:
        short = self.part.short
        return short if short and self._kept[_CONTROL] & _SHORT else self.part.span

    def _forget(self) -> None:
        self._counts = self.part.nothing
        self._outside = 0
        self._trigger = 0


def _speed(celsius: float) -> float:
    """m/s of sound in dry air."""
    return _SPEED_AT_ZERO * sqrt(1 + celsius / _ZERO_CELSIUS_K)


@dataclass(frozen=True, slots=True)
class Urm12Options(UrmOptions):
    """A URM12's."""

    address: int = 0x0B
    unit_mm: float = 10.0


class Urm12Sensor(UrmSensor):
    """15 m in centimetres, 3 times a second."""

    part = Part(product=1, nothing=0x0000, span=Span(15.0, 333_000_000))


@dataclass(frozen=True, slots=True)
class Urm13Options(UrmOptions):
    """A URM13's."""

    address: int = 0x0D
    unit_mm: float = 10.0


class Urm13Sensor(UrmSensor):
    """9 m 10 times a second, or 1.5 m 50 times; in centimetres, as the maker's library has it."""

    part = Part(product=3, nothing=0xFFFF, span=Span(9.0, 100_000_000), short=Span(1.5, 20_000_000))


@dataclass(frozen=True, slots=True)
class Urm14Options(UrmOptions):
    """A URM14's."""

    address: int = 0x0C
    unit_mm: float = 0.1


class Urm14Sensor(UrmSensor):
    """1.5 m in tenths of a millimetre, 30 times a second."""

    part = Part(product=2, nothing=0xFFFF, span=Span(1.5, 33_000_000))


@dataclass(frozen=True, slots=True)
class Urm15Options(UrmOptions):
    """A URM15's."""

    address: int = 0x0F


class Urm15Sensor(UrmSensor):
    """5 m in millimetres, 10 times a second."""

    part = Part(product=5, nothing=0xFFFF, span=Span(5.0, 100_000_000))
