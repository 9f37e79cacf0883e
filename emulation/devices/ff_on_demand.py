"""An emulated JSN-SR04T (mode 3) or AJ-SR04M (mode 4): a byte makes it ping, an FF H L SUM frame answers."""

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
_LISTENS_NS = 60_000_000
"""By its data sheet it gives up then."""


@dataclass(frozen=True, slots=True)
class FfOnDemandOptions(FfOptions):
    """What differs between boards."""

    part: str = "jsn-sr04t"
    trigger: int | None = None
    """The byte at which it pings; None: as the part has it."""


class FfOnDemandSensor(SerialDevice):
    """Pings at its trigger byte, and answers when it has listened. Meanwhile it takes no other."""

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: FfOnDemandOptions = FfOnDemandOptions(),
    ) -> None:
        super().__init__(name, BAUD)
        self._sonar = Sonar(surroundings, self.faults, random)
        self._options = options
        self._trigger = options.chosen.trigger if options.trigger is None else options.trigger
        self._answers_ns = NEVER_NS

    def receive(self, data: bytes, now_ns: int) -> None:
        """Ping, if the trigger is among the bytes."""
        if self._trigger in data and self._answers_ns == NEVER_NS:
            self._sonar.fire(now_ns)
            self._answers_ns = now_ns + _LISTENS_NS * self._sonar.slowness + self._delay_ns()

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), **RANGING_VERBS}

    def _power_up(self, now_ns: int) -> None:
        del now_ns

    def _power_down(self) -> None:
        self._answers_ns = NEVER_NS
        self.output.stop()

    def _next_ns(self) -> int:
        return self._answers_ns

    def _step(self, now_ns: int) -> None:
        if now_ns < self._answers_ns:
            return
        self._answers_ns = NEVER_NS
        distance = self._sonar.first(self._options.chosen.reach)
        garbage = "garbage" in self.faults
        self.send(self._sonar.random.randbytes(4) if garbage else self._options.message(distance), now_ns)
