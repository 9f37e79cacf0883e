"""An emulated DFRobot A02YYUW: a ranger which fires by itself and sends FF H L SUM."""

from collections.abc import Mapping
from dataclasses import dataclass
from random import Random

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.devices.sonar import RANGING_VERBS, Sonar
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.faults import Verb

BAUD = 9600
_NEAREST = 0.03
_HEADER = 0xFF
_SILENT = -1


@dataclass(frozen=True, slots=True)
class A02yyuwOptions:
    """What differs between makes and settings of this sensor."""

    period_ns: int = 100_000_000
    lag_ns: int = 100_000_000
    """From the echo's arrival (or the end of listening) to the first bit: the sheet says 100-300 ms."""
    reach: float = 4.5
    """m."""
    no_echo: int = 0
    """The value (mm) sent when nothing is heard: there is no standard one; -1 sends nothing."""


class A02yyuwSensor(SerialDevice):
    """Fires every period, in a phase of its own from power-up, and sends the first echo `lag_ns` later.

    It corrects for temperature by a thermometer of its own, so what it sends are true millimetres.
    """

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: A02yyuwOptions = A02yyuwOptions(),
    ) -> None:
        super().__init__(name, BAUD)
        self._sonar = Sonar(surroundings, self.faults, random)
        self._options = options
        self._phase_ns = random.randrange(options.period_ns)
        full_ns = round(2e9 * options.reach / surroundings.speed_of_sound)
        self._listens_ns = min(full_ns, options.period_ns)
        self._fire_ns = self._heard_ns = NEVER_NS

    def receive(self, data: bytes, now_ns: int) -> None:
        """Nothing: this sensor takes no commands."""

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), **RANGING_VERBS}

    def _power_up(self, now_ns: int) -> None:
        self._fire_ns = now_ns + self._phase_ns

    def _power_down(self) -> None:
        self._fire_ns = self._heard_ns = NEVER_NS
        self.output.stop()

    def _next_ns(self) -> int:
        return min(self._fire_ns, self._heard_ns)

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._heard_ns:
            self._tell(self._heard_ns - self._listens_ns)
            self._heard_ns = NEVER_NS
        if now_ns >= self._fire_ns:
            self._sonar.fire(self._fire_ns)
            self._heard_ns = self._fire_ns + self._listens_ns
            self._fire_ns += self._options.period_ns * self._sonar.slowness

    def _tell(self, fired_ns: int) -> None:
        """Send what was heard, so long after it came."""
        distance = self._sonar.first(self._options.reach)
        way = 2 * (self._options.reach if distance is None else distance)
        came_ns = fired_ns + round(1e9 * way / self._sonar.speed_of_sound)
        self.send(self._frame(distance), came_ns + self._options.lag_ns + self._delay_ns())

    def _frame(self, distance: float | None) -> bytes:
        if "garbage" in self.faults:
            return self._sonar.random.randbytes(4)
        if distance is None:
            return b"" if self._options.no_echo == _SILENT else frame(self._options.no_echo)
        if distance < _NEAREST:
            return frame(_below_minimum(distance))
        return frame(round(distance * 1000))


def frame(millimetres: int) -> bytes:
    """FF H L SUM."""
    high, low = divmod(millimetres, 256)
    return bytes((_HEADER, high, low, (_HEADER + high + low) & 0xFF))


def _below_minimum(distance: float) -> int:
    """What is sent for an object in the blind zone: a value below the minimum, never the no-echo 0."""
    return max(1, int(distance * 1000))
