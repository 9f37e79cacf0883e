"""What every emulated bus has: a host end that can be unplugged, and the devices which it runs."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Generic, TypeVar

from echogrid.emulation.devices.device import EmulatedDevice
from echogrid.emulation.faults import Fallible, Verb

In = TypeVar("In")
Out = TypeVar("Out")


class Bus(Fallible, Generic[In, Out]):
    """A bus with its devices. The host receives `In` and sends `Out`, as at a drivers.bus.Port."""

    def __init__(self, name: str, devices: Sequence[EmulatedDevice]) -> None:
        super().__init__(name, {"unplug": Verb(self.unplug, self.plug_in)})
        self._devices = devices
        self._plugged = True
        self._unplugs = 0
        self._due_ns: int | None = None
        for part in (self, *devices):
            part.on_change = self._reconsider

    @property
    def present(self) -> bool:
        """Whether the host has the port."""
        return self._plugged

    @property
    def unplugs(self) -> int:
        """How often the host lost the port: a port that was open before a loss stays lost."""
        return self._unplugs

    def switch_on(self, now_ns: int) -> None:
        """Give its devices power for the first time."""
        for device in self._devices:
            device.switch_on(now_ns)

    def next_event_ns(self) -> int:
        """When something is due next; NEVER_NS if nothing is. Kept until a change: it is asked often."""
        if self._due_ns is None:
            self._due_ns = super().next_event_ns()
        return self._due_ns

    def send(self, items: Sequence[Out], now_ns: int) -> None:
        """Send from the host."""
        self.advance(now_ns)
        self._send(items, now_ns)
        self._reconsider()

    def take(self, now_ns: int) -> tuple[In, ...]:
        """What has reached the host by now, each item given once."""
        self.advance(now_ns)
        return self._take() if self.has_received() else ()

    def unplug(self, now_ns: int) -> None:
        """Fault `unplug`: the adapter leaves the host."""
        del now_ns
        self._plugged = False
        self._unplugs += 1
        self._drop()

    def plug_in(self, now_ns: int) -> None:
        """The end of `unplug`."""
        del now_ns
        self._plugged = True

    @abstractmethod
    def has_received(self) -> bool:
        """Whether something waits to be taken."""

    def _reconsider(self) -> None:
        self._due_ns = None

    @abstractmethod
    def _send(self, items: Sequence[Out], now_ns: int) -> None:
        """Put on the wire, or queue for it."""

    @abstractmethod
    def _take(self) -> tuple[In, ...]:
        """Hand over what waits."""

    @abstractmethod
    def _drop(self) -> None:
        """Lose what is between the devices and the host."""


class PoweringBus(Bus[In, Out]):
    """A bus whose adapter also feeds the devices: without it they lose their power."""

    def unplug(self, now_ns: int) -> None:
        """Fault `unplug`: the adapter leaves the host, and the devices go dark."""
        super().unplug(now_ns)
        for device in self._devices:
            device.lose_power("bus unplugged", now_ns)

    def plug_in(self, now_ns: int) -> None:
        """The end of `unplug`."""
        super().plug_in(now_ns)
        for device in self._devices:
            device.restore_power("bus unplugged", now_ns)
