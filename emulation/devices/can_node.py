"""An emulated device on a CAN bus."""

from abc import abstractmethod
from operator import itemgetter
from typing import ClassVar

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.emulation.devices.device import EmulatedDevice

_DUE_NS = itemgetter(0)


class CanNode(EmulatedDevice):
    """Hands frames to the bus, each with the time from which on it is to be sent."""

    fd: ClassVar[bool] = False
    """Whether it speaks CAN-FD; if not, it takes no such frames."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._outbox: list[tuple[int, CanFrame]] = []

    @abstractmethod
    def receive(self, frame: CanFrame, now_ns: int) -> None:
        """Take a frame that another node has just sent. Called with power only."""

    def take(self, now_ns: int) -> list[CanFrame]:
        """The frames to be sent by now, each given once."""
        if not self._outbox:
            return []
        due = [frame for due_ns, frame in self._outbox if due_ns <= now_ns]
        if due:
            self._outbox = [(due_ns, frame) for due_ns, frame in self._outbox if due_ns > now_ns]
        return due

    def next_send_ns(self) -> int:
        """When the next frame is to be sent; NEVER_NS if none is."""
        return min(self._outbox, key=_DUE_NS)[0] if self._outbox else NEVER_NS

    def post(self, frame: CanFrame, due_ns: int) -> None:
        """Have a frame sent from that time on."""
        self._outbox.append((due_ns, frame))

    def withdraw(self) -> None:
        """Lose the frames which are not yet sent."""
        self._outbox.clear()
