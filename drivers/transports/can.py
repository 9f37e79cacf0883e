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
from echogrid.drivers.transports.can_link import FD_MTU, CanLink, read_link
from echogrid.drivers.transports.can_supervisor import CanSupervisor, classic, down
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
    """A CAN bus. What comes in and is no data or remote frame is counted and dropped; frames of CAN-FD, too,
    unless it was opened for them.

    So are frames to send in a bus-off and for a while after a refusal: they would be stale when they go out;
    and all of them on a port which may only listen. That acknowledges others' frames all the same.
    """

    def __init__(
        self,
        address: str,
        *,
        interface: str = "socketcan",
        bitrate: int = 250_000,
        fd: bool = False,
        listen_only: bool = False,
        more: Mapping[str, object] = MappingProxyType({}),
        look: Callable[[str], CanLink | None] = read_link,
    ) -> None:
        """`interface` is python-can's name for it, `fd` asks for CAN-FD, `more` is what else it shall know;
        `look` asks the kernel. With `listen_only` nothing is sent."""
        require_between("bitrate", bitrate, 10_000, 1_000_000)
        self._address = address
        self._bitrate = bitrate
        self._listen_only = listen_only
        self._fd = fd
        self._look = look if interface in OF_THE_KERNEL else None
        self.counts: Counter[str] = Counter()
        self._supervisor = CanSupervisor(address, bitrate, self.counts, fd)
        self._channel = self._made(interface, more)

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        self.close()
        link = self._asked(None)
        if link is not None and not link.up:
            raise PortError(down(self._address, link, self._bitrate, self._fd))
        if self._fd and link is not None and link.mtu is not None and link.mtu < FD_MTU:
            raise PortError(classic(self._address, link, self._bitrate))
        self._channel.open()
        self._supervisor.opened(time.monotonic_ns(), link)

    def close(self) -> None:
        """Let go. May be called twice."""
        self._supervisor.closed()
        self._channel.close()

    def write(self, items: Sequence[CanFrame]) -> None:
        """Send. Raises PortError when the port is lost."""
        if self._listen_only:
            self.counts["frames not to be sent"] += len(items)
            return
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
        if interface == SLCAN and self._fd:
            raise ValueError(
                'slcan has no CAN-FD: use an adapter that the kernel knows, interface "socketcan"'
            )
        if interface == SLCAN:
            return SlcanChannel(self._address, self._bitrate, _tty_baudrate(more), self.counts)
        fd = {"fd": True} if self._fd else {}
        options = {"interface": interface, "bitrate": self._bitrate, **fd, **more}
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
