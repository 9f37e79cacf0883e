"""What every emulated ranger has that speaks on a serial line when it is spoken to."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from random import Random

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.collision import collided
from echogrid.emulation.devices.device import LOOKED_UP
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.devices.sonar import RANGING_VERBS, Sonar
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.faults import Verb
from echogrid.emulation.scene import Echo


class SerialRanger(SerialDevice):
    """A sonar on a line. A maker's own part: which bytes start a ranging, and which tell of it."""

    def __init__(
        self, name: str, baud: int, surroundings: Surroundings, random: Random, bits_per_byte: int = 10
    ) -> None:
        super().__init__(name, baud, bits_per_byte)
        self.sonar = Sonar(surroundings, self.faults, random)
        self._twin = random.randbytes(16)
        self._heard_ns = self._done_ns = NEVER_NS

    def ranging(self, now_ns: int) -> bool:
        """Whether a ranging is under way."""
        return self._done_ns != NEVER_NS and now_ns < self._done_ns

    def reply(self, data: bytes, start_ns: int) -> None:
        """Answer from that time on; a twin at the same address does so at nearly the same time."""
        random = self.sonar.random
        if "garbage" in self.faults:
            data = random.randbytes(random.randint(1, 2 * len(data)))
        if "address_conflict" in self.faults:
            later = random.randrange(self.bits_per_byte)
            data = collided(data, self._twin[: len(data)], later, self.bits_per_byte)
        self.send(data, start_ns + self._delay_ns())

    def _verbs(self) -> Mapping[str, Verb]:
        shared = {"address_conflict": LOOKED_UP} if self.shares_line else {}
        return {**super()._verbs(), **RANGING_VERBS, **shared}

    def _begin(self, now_ns: int, lasts_ns: int, listens_ns: int, silent: bool = False) -> None:
        """Fire now, listen for so long, and have done after `lasts_ns`."""
        self.sonar.fire(now_ns, silent)
        self._done_ns = now_ns + lasts_ns * self.sonar.slowness
        self._heard_ns = min(now_ns + listens_ns, self._done_ns)

    def _power_up(self, now_ns: int) -> None:
        del now_ns
        self._forget()

    def _power_down(self) -> None:
        self._heard_ns = self._done_ns = NEVER_NS
        self.output.stop()

    def _next_ns(self) -> int:
        return self._heard_ns

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._heard_ns:
            self._heard_ns = NEVER_NS
            self._hear(self.sonar.echoes())

    @abstractmethod
    def _hear(self, echoes: Sequence[Echo]) -> None:
        """Make of what was heard what will be told."""

    @abstractmethod
    def _forget(self) -> None:
        """Have all that is volatile at its default."""
