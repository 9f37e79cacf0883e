"""An emulated DYP-A02 with RS485: a Modbus slave that pings when its distance is read."""

from collections.abc import Mapping
from dataclasses import dataclass
from random import Random

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.modbus_slave import ILLEGAL_ADDRESS, ModbusSlave, SlaveOptions
from echogrid.emulation.devices.sonar import RANGING_VERBS, Sonar
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.faults import Verb

_FILTERED, _REAL_TIME, _TEMPERATURE = 0x0100, 0x0101, 0x0102
_SILENT = -1
_ZERO_CELSIUS_K = 273.15
_SPEED_AT_ZERO = 331.3
"""m/s in dry air."""


@dataclass(frozen=True, slots=True)
class DypRs485Options(SlaveOptions):
    """What differs between parts and settings."""

    filtered_ns: int = 520_000_000
    """From a request for the filtered distance to the reply."""
    real_time_ns: int = 120_000_000
    """The same for the real-time distance."""
    reach: float = 4.5
    """m."""
    no_echo: int = 0
    """The value (mm) when nothing is heard: unknown, so that of its kin; -1 does not answer at all."""


class DypRs485Sensor(ModbusSlave):
    """Fires when it is asked, and answers when it has measured.

    Its filter is not known: the filtered distance is that of one ping, fired as late before the answer as
    the real-time one. Its distances are true, because it measures the temperature.
    """

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: DypRs485Options = DypRs485Options(),
    ) -> None:
        super().__init__(name, options, random)
        self._sonar = Sonar(surroundings, self.faults, random)
        self._options = options
        self._asked = range(0)
        self._fire_ns = self._done_ns = NEVER_NS
        self._millimetres = 0

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), **RANGING_VERBS}

    def _power_down(self) -> None:
        super()._power_down()
        self._fire_ns = self._done_ns = NEVER_NS

    def _next_ns(self) -> int:
        return min(super()._next_ns(), self._fire_ns, self._done_ns)

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._done_ns:
            self._done_ns = NEVER_NS
            self._tell(now_ns)
        if now_ns >= self._fire_ns:
            self._sonar.fire(now_ns)
            self._fire_ns = NEVER_NS
        super()._step(now_ns)

    def _read(self, registers: range, now_ns: int) -> bytes:
        """A reading of a distance begins a ping; it is answered later."""
        if _FILTERED not in registers and _REAL_TIME not in registers:
            return super()._read(registers, now_ns)
        if None in map(self._word, registers):
            return super()._read(registers, now_ns)
        lasts_ns = self._options.filtered_ns if _FILTERED in registers else self._options.real_time_ns
        self._asked = registers
        self._done_ns = now_ns + lasts_ns * self._sonar.slowness
        self._fire_ns = self._done_ns - self._options.real_time_ns
        return b""

    def _tell(self, now_ns: int) -> None:
        distance = self._sonar.first(self._options.reach)
        if distance is None and self._options.no_echo == _SILENT:
            return
        self._millimetres = self._options.no_echo if distance is None else max(1, round(distance * 1000))
        self._reply(super()._read(self._asked, now_ns), now_ns)

    def _word(self, register: int) -> int | None:
        if register in (_FILTERED, _REAL_TIME):
            return self._millimetres
        if register == _TEMPERATURE:
            warmth = (self._sonar.speed_of_sound / _SPEED_AT_ZERO) ** 2
            return round(10 * _ZERO_CELSIUS_K * (warmth - 1)) & 0xFFFF
        return None

    def _write(self, register: int, word: int, now_ns: int) -> int:
        """Refuse: which registers of it can be written is not known."""
        del register, word, now_ns
        return ILLEGAL_ADDRESS
