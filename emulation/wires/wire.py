"""What every served wire does: it stands while its bus is plugged in, and carries what the bus brings."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Generic, TypeVar

from echogrid.drivers.clock import Clock
from echogrid.emulation.buses.bus import Bus
from echogrid.emulation.wires.loop import Loop

In = TypeVar("In")
Out = TypeVar("Out")


class Wire(ABC, Generic[In, Out]):
    """A bus made visible to other processes. Whoever serves it calls `pump` when the bus has an event."""

    def __init__(self, bus: Bus[In, Out], clock: Clock, loop: Loop) -> None:
        self._bus = bus
        self._clock = clock
        self._loop = loop
        self._attached = False
        self._unplugs = bus.unplugs

    def pump(self) -> None:
        """Run the bus up to now, follow its plug, and carry what it brought."""
        items = self._bus.take(self._clock.now_ns())
        if self._attached and self._unplugs != self._bus.unplugs:
            self.close()
        if not self._attached and self._bus.present:
            self._unplugs = self._bus.unplugs
            self._attach()
            self._attached = True
        if items and self._attached:
            self._deliver(items)

    def close(self) -> None:
        """Take it away from its clients. May be called twice."""
        if self._attached:
            self._attached = False
            self._detach()

    def _send(self, items: Sequence[Out]) -> None:
        """Send what a client gave, unless the bus has gone since."""
        now_ns = self._clock.now_ns()
        self._bus.advance(now_ns)
        if self._unplugs == self._bus.unplugs:
            self._bus.send(items, now_ns)

    @abstractmethod
    def _attach(self) -> None:
        """Come into being."""

    @abstractmethod
    def _detach(self) -> None:
        """Be gone."""

    @abstractmethod
    def _deliver(self, items: Sequence[In]) -> None:
        """Carry to the clients."""
