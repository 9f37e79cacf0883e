"""The same devices and loop on a clock that jumps: every event in its order, and always alike."""

from collections.abc import Sequence
from typing import Any, Protocol

from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.readings import Reading
from echogrid.runtime.acquisition import DeviceReport, device_reports
from echogrid.runtime.pump import PortState, Pump
from echogrid.runtime.reading_queue import ReadingQueue


class SimulatedPort(Protocol):
    """An in-memory port, which knows when it will have something."""

    def ready_ns(self) -> int:
        """When reading or the device behind it is due next."""
        ...


class Simulation:
    """A clock which, asked to sleep, lets all buses live through the time; and their readings.

    Each bus's turn comes when its devices or its wire are due; ties go to the bus which is named first.
    """

    def __init__(self, clock: JumpingClock, pumps: Sequence[Pump[Any, Any]], queue: ReadingQueue) -> None:
        self._clock = clock
        self._pumps = pumps
        self._queue = queue

    def now_ns(self) -> int:
        """The simulated time."""
        return self._clock.now_ns()

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """Play everything that happens up to the deadline. A turn of one bus changes no other's."""
        due = [(self._due_ns(pump), index) for index, pump in enumerate(self._pumps)]
        while due and (first := min(due))[0] <= deadline_ns:
            due_ns, index = first
            self._clock.sleep_until_ns(due_ns)
            self._pumps[index].turn()
            due[index] = self._due_ns(self._pumps[index]), index
        self._clock.sleep_until_ns(deadline_ns)

    def drain(self) -> list[Reading]:
        """What came in since the last call, in order of arrival."""
        return self._queue.drain()

    def drain_overflow(self) -> list[Reading]:
        """What came in but had to give way since the last call."""
        return self._queue.drain_overflow()

    def report(self, now_ns: int) -> list[DeviceReport]:
        """How every device is."""
        return device_reports(self._pumps, now_ns)

    def stop(self) -> None:
        """Let the ports go."""
        for pump in self._pumps:
            pump.close()

    def _due_ns(self, pump: Pump[Any, Any]) -> int:
        if pump.state is PortState.CLOSED:
            return pump.due_ns
        port: SimulatedPort = pump.port  # type: ignore[assignment]  # in-memory ports say when they are ready
        return min(pump.due_ns, port.ready_ns())
