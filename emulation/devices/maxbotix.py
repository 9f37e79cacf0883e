"""An emulated MaxBotix ranger with a serial output: it fires by itself and sends lines `Rnnn` CR."""

from collections.abc import Mapping
from dataclasses import dataclass
from random import Random

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.maxbotix_kinds import Kind, kind_of
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.devices.sonar import RANGING_VERBS, Sonar
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.faults import Verb

BAUD = 9600
_ACQUIRED_NS = 10_000_000_000
_RELEASED_NS = 5_000_000_000
"""A presence flag comes so long after the object, and goes so long after it."""


@dataclass(frozen=True, slots=True)
class MaxbotixOptions:
    """What differs between rangers."""

    model: str = "MB1013"
    no_echo: int | None = None
    """The number sent when nothing is heard; None: the largest."""

    def __post_init__(self) -> None:
        kind_of(self.model)


class MaxbotixSensor(SerialDevice):
    """Tells its name at power-up if its kind does so, and then goes from cycle to cycle, with a ping at the
    beginning of each and a line near its end."""

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: MaxbotixOptions = MaxbotixOptions(),
    ) -> None:
        super().__init__(name, BAUD)
        self._sonar = Sonar(surroundings, self.faults, random)
        self._model = options.model
        self._kind: Kind = kind_of(options.model)
        self._no_echo = self._kind.most if options.no_echo is None else options.no_echo
        self._size = self._kind.size(surroundings.speed_of_sound)
        self._listens_ns = round(2e9 * self._kind.most * self._size / surroundings.speed_of_sound)
        self._phase_ns = random.randrange(self._kind.cycle_ns)
        self._fire_ns = self._heard_ns = NEVER_NS
        self._flag = Flag()

    def receive(self, data: bytes, now_ns: int) -> None:
        """Nothing: its RX pin is open, and no serial input at all."""

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), **RANGING_VERBS}

    def _power_up(self, now_ns: int) -> None:
        self._flag = Flag()
        self.send(self._kind.greeting(self._model), now_ns + self._kind.greets_ns)
        self._fire_ns = now_ns + self._kind.starts_ns + self._phase_ns

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
            self._fire_ns += self._kind.cycle_ns * self._sonar.slowness

    def _tell(self, fired_ns: int) -> None:
        """Send the line of that cycle."""
        distance = self._sonar.first(self._kind.most * self._size)
        number = self._no_echo if distance is None else self._number(distance)
        self._flag.see(distance is not None, fired_ns)
        line = self._kind.line(number, self._flag.up)
        garbage = "garbage" in self.faults
        data = self._sonar.random.randbytes(len(line)) if garbage else line
        self.send(data, fired_ns + self._kind.sends_ns + self._delay_ns())

    def _number(self, distance: float) -> int:
        return min(max(round(distance / self._size), self._kind.least), self._kind.most)


class Flag:
    """Whether an object is there, with the sloth of a ParkSonar."""

    def __init__(self) -> None:
        self.up = False
        self._changed_ns: int | None = None

    def see(self, seen: bool, now_ns: int) -> None:
        """Take what one ping says."""
        if seen == self.up:
            self._changed_ns = None
        elif self._changed_ns is None:
            self._changed_ns = now_ns
        elif now_ns - self._changed_ns >= (_ACQUIRED_NS if seen else _RELEASED_NS):
            self.up = seen
            self._changed_ns = None
