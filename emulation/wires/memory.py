"""A bus in memory: the host's port without a kernel, on whatever clock it is given."""

from collections.abc import Sequence
from typing import Generic, TypeVar

from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.clock import Clock
from echogrid.drivers.errors import PortError
from echogrid.emulation.buses.bus import Bus

In = TypeVar("In")
Out = TypeVar("Out")


class MemoryPort(Generic[In, Out]):
    """The host's end of an emulated bus, a drivers.bus.Port.

    A port which was open while its bus was unplugged stays lost until it is opened again, as with a tty.
    """

    def __init__(self, bus: Bus[In, Out], clock: Clock) -> None:
        self._bus = bus
        self._clock = clock
        self._unplugs: int | None = None

    def open(self) -> None:
        """Make ready; what came before is not seen. Raises PortError while the bus is unplugged."""
        self._bus.take(self._clock.now_ns())
        if not self._bus.present:
            raise PortError(f"{self._bus.name}: no such port (it is unplugged: clear its fault)")
        self._unplugs = self._bus.unplugs

    def close(self) -> None:
        """Let go. May be called twice."""
        self._unplugs = None

    def write(self, items: Sequence[Out]) -> None:
        """Send. Raises PortError when the bus was unplugged."""
        self._bus.advance(self._clock.now_ns())
        self._require()
        self._bus.send(items, self._clock.now_ns())

    def read(self, timeout_s: float) -> Sequence[In]:
        """What has come by now; never waits. Raises PortError when the bus was unplugged."""
        del timeout_s
        self._bus.advance(self._clock.now_ns())
        self._require()
        return self._bus.take(self._clock.now_ns())

    def ready_ns(self) -> int:
        """When `read` is to be called next: it would give something, or the bus has something to do.

        NEVER_NS while the port is closed, or if nothing is due.
        """
        if self._unplugs is None:
            return NEVER_NS
        if self._unplugs != self._bus.unplugs or self._bus.has_received():
            return self._clock.now_ns()
        return self._bus.next_event_ns()

    def _require(self) -> None:
        if self._unplugs is None:
            raise PortError(f"{self._bus.name}: the port is closed (open it first)")
        if self._unplugs != self._bus.unplugs:
            raise PortError(f"{self._bus.name}: the port is lost (it was unplugged: open it again)")
