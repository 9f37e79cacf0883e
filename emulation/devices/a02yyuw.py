"""An emulated DFRobot A02YYUW or a sibling: a ranger which fires by itself and sends FF H L SUM."""

from collections.abc import Mapping
from dataclasses import dataclass
from random import Random

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.ff_parts import FfOptions
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.devices.sonar import RANGING_VERBS, Sonar
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.faults import Verb

BAUD = 9600


@dataclass(frozen=True, slots=True)
class A02yyuwOptions(FfOptions):
    """What differs between makes and settings of this sensor."""

    period_ns: int = 100_000_000
    lag_ns: int | None = None
    """From the echo's arrival (or the end of listening) to the first bit; None: as the part has it."""


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
        self._reach = options.chosen.reach
        self._lag_ns = options.chosen.lag_ns if options.lag_ns is None else options.lag_ns
        full_ns = round(2e9 * self._reach / surroundings.speed_of_sound)
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
        distance = self._sonar.first(self._reach)
        way = 2 * (self._reach if distance is None else distance)
        came_ns = fired_ns + round(1e9 * way / self._sonar.speed_of_sound)
        garbage = "garbage" in self.faults
        data = self._sonar.random.randbytes(4) if garbage else self._options.message(distance)
        self.send(data, came_ns + self._lag_ns + self._delay_ns())
