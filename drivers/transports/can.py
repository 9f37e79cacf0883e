"""CAN ports: slcan adapters by a reader of our own, every other interface by python-can."""

import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Protocol

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import Health
from echogrid.drivers.errors import PortError
from echogrid.drivers.limits import require_between
from echogrid.drivers.supervised import Supervised
from echogrid.drivers.transports.can_link import CanLink, read_link
from echogrid.drivers.transports.can_supervisor import CanSupervisor, down
from echogrid.drivers.transports.python_can import PythonCanChannel
from echogrid.drivers.transports.slcan import TTY_BAUD, SlcanChannel

SLCAN = "slcan"
OF_THE_KERNEL = ("socketcan",)
"""Interfaces of which the kernel can be asked, by the name that is their channel."""


class Channel(Protocol):
    """What carries frames. Everything but `close` may raise PortError, which names the port and the mend."""

    def open(self) -> None:
        """Make ready."""
        ...

    def close(self) -> None:
        """Let go. May be called twice."""
        ...

    def send(self, frames: Sequence[CanFrame]) -> int:
        """Send; how many were, before the queue was full."""
        ...

    def receive(self, wait_s: float) -> list[CanFrame]:
        """What has come in."""
        ...


class CanPort(Supervised):
    """A CAN bus. What comes in and is no classic data or remote frame is counted and dropped.

    So are frames to send in a bus-off, and for a while after a refusal: they would be stale when they go out.
    """

    def __init__(
        self,
        address: str,
        *,
        interface: str = "socketcan",
        bitrate: int = 250_000,
        more: Mapping[str, object] = MappingProxyType({}),
        look: Callable[[str], CanLink | None] = read_link,
    ) -> None:
        """`interface` is python-can's name for it, `more` what else it shall know; `look` asks the kernel."""
        require_between("bitrate", bitrate, 10_000, 1_000_000)
        self._address = address
        self._bitrate = bitrate
        self._look = look if interface in OF_THE_KERNEL else None
        self.counts: Counter[str] = Counter()
        self._supervisor = CanSupervisor(address, bitrate, self.counts)
        self._channel = self._made(interface, more)

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        self.close()
        link = self._asked(None)
        if link is not None and not link.up:
            raise PortError(down(self._address, link, self._bitrate))
        self._channel.open()
        self._supervisor.opened(time.monotonic_ns(), link)

    def close(self) -> None:
        """Let go. May be called twice."""
        self._supervisor.closed()
        self._channel.close()

    def write(self, items: Sequence[CanFrame]) -> None:
        """Send. Raises PortError when the port is lost."""
        sent = 0
        if self._supervisor.may_send(time.monotonic_ns()):
            sent = self._channel.send(items)
            if sent < len(items):
                self._supervisor.refused(time.monotonic_ns())
            else:
                self._supervisor.sent()
        if sent < len(items):
            self.counts["unsent frames"] += len(items) - sent

    def read(self, timeout_s: float) -> Sequence[CanFrame]:
        """What has come in; waits for something at most so long. Raises PortError when the port is lost."""
        malformed = self._malformed
        frames = self._channel.receive(timeout_s)
        now_ns = time.monotonic_ns()
        self._supervisor.heard(now_ns, len(frames), self._malformed - malformed)
        if now_ns >= self._supervisor.look_ns:
            trouble = self._supervisor.looked(now_ns, self._asked(self._supervisor.link))
            if trouble:
                raise PortError(trouble)
        return frames

    def health(self, now_ns: int) -> Health:
        """How the bus is: its worst trouble, or what is set up badly, with the line that mends it."""
        condition = self._supervisor.condition(now_ns)
        return Health(condition.state, condition.message, {**self.counts, **self._supervisor.link_counts()})

    def _asked(self, otherwise: CanLink | None) -> CanLink | None:
        """The link, None if there is no such; `otherwise` if the kernel cannot be asked."""
        if self._look is None:
            return otherwise
        try:
            return self._look(self._address)
        except OSError:
            return otherwise

    @property
    def _malformed(self) -> int:
        return self.counts["malformed lines"]

    def _made(self, interface: str, more: Mapping[str, object]) -> Channel:
        if interface == SLCAN:
            return SlcanChannel(self._address, self._bitrate, _tty_baudrate(more), self.counts)
        options = {"interface": interface, "bitrate": self._bitrate, **more}
        erred = self._supervisor.erred if self._look else _ignore
        return PythonCanChannel(self._address, options, self.counts, erred)


def _tty_baudrate(more: Mapping[str, object]) -> int:
    """The only other thing that slcan may be told. Raises ValueError for any else."""
    for key, value in more.items():
        if key != "tty_baudrate" or not isinstance(value, int):
            raise ValueError(f"{key} = {value!r} is no option of slcan: expected tty_baudrate, in bit/s")
    return int(str(more.get("tty_baudrate", TTY_BAUD)))


def _ignore(identifier: int, data: bytes) -> None:
    """Error frames of other interfaces than the kernel's say nothing in their identifiers."""
