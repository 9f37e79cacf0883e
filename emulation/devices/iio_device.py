"""What every ranger behind an emulated kernel has: files that are read, one of which pings."""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from errno import ENOENT
from random import Random

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.device import EmulatedDevice
from echogrid.emulation.devices.sonar import RANGING_VERBS, Sonar
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.faults import Verb

_READ_NS = 20_000
"""A file behind which nothing happens."""


@dataclass(frozen=True, slots=True)
class Reply:
    """What came of a read."""

    text: bytes = b""
    errno: int = 0


@dataclass(frozen=True, slots=True)
class Files:
    """Those which never change."""

    name: str
    """Of the kernel's driver."""
    scale: str
    """m for each step of the raw value, as the kernel writes it."""

    def reply(self, attribute: str) -> Reply:
        """What one of them says."""
        texts = {"name": self.name, "in_distance_scale": self.scale}
        return Reply(f"{texts[attribute]}\n".encode()) if attribute in texts else Reply(errno=ENOENT)


class IioDevice(EmulatedDevice):
    """A ranger with its driver in the kernel. The bus begins one read at a time, and takes its reply."""

    def __init__(
        self, name: str, device: str, surroundings: Surroundings, random: Random, files: Files
    ) -> None:
        """`device` is the name by which it is read."""
        super().__init__(name)
        self.device = device
        self.sonar = Sonar(surroundings, self.faults, random)
        self._files = files
        self._ranging = False
        self._reply: Reply | None = None
        self._due_ns = NEVER_NS
        self._then: Callable[[int], None] = self._nothing

    def begin(self, attribute: str, now_ns: int) -> None:
        """Begin to read a file."""
        self._reply = None
        if attribute == "in_distance_raw":
            self._ranging = True
            self._range(now_ns)
        else:
            self._end(self._files.reply(attribute), now_ns + _READ_NS)
        self.on_change()

    def take_reply(self) -> Reply | None:
        """What came of the read, once it is over."""
        reply, self._reply = self._reply, None
        return reply

    def abandon(self) -> None:
        """Nobody waits for the reply any more."""
        self._ranging = False
        self._reply, self._due_ns = None, NEVER_NS

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), **RANGING_VERBS}

    def _next_ns(self) -> int:
        return self._due_ns

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._due_ns:
            self._due_ns = NEVER_NS
            self._then(now_ns)

    def _after(self, due_ns: int, then: Callable[[int], None]) -> None:
        """What the read under way does next, and when."""
        self._due_ns, self._then = due_ns, then

    def _end(self, reply: Reply, at_ns: int) -> None:
        """The read under way is over at a time, with this reply."""

        def end(now_ns: int) -> None:
            del now_ns
            self._ranging = False
            self._reply = reply

        self._after(at_ns, end)

    def _nothing(self, now_ns: int) -> None:
        """Do nothing more."""

    def _power_up(self, now_ns: int) -> None:
        """It has no memory."""

    def _power_down(self) -> None:
        if self._ranging:
            self._break_off()

    @abstractmethod
    def _range(self, now_ns: int) -> None:
        """Ping, or find out that this can't be."""

    @abstractmethod
    def _break_off(self) -> None:
        """Lose the power while a ping is under way."""
