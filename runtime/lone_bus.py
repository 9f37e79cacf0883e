"""One bus of the machine, worked by hand: a port and its line, until something has come about."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from echogrid.drivers.bus import Port
from echogrid.drivers.clock import Clock
from echogrid.drivers.device import BusLine
from echogrid.drivers.errors import PortError
from echogrid.drivers.readings import Reading
from echogrid.runtime.pump import PortState, Pump


class LoneBus:
    """Pumps one bus in the caller's thread."""

    def __init__(self, line: BusLine[Any, Any], port: Port[Any, Any], clock: Clock) -> None:
        self._clock = clock
        self._readings: list[Reading] = []
        self.pump = Pump(line, port, clock, self._readings.extend)

    def open(self) -> None:
        """Open the port. Raises PortError, with the mend, if that can't be."""
        self.pump.turn()
        if self.pump.state is PortState.CLOSED:
            raise PortError(self.pump.trouble)

    def turn_until(self, reached: Callable[[], bool], within_s: float) -> bool:
        """Carry what is to be carried until that is so; whether it came about in time."""
        deadline_ns = self._clock.now_ns() + round(within_s * 1e9)
        while not reached():
            if self._clock.now_ns() >= deadline_ns:
                return False
            self.pump.turn()
        return True

    @property
    def waiting(self) -> int:
        """How many readings there are to take."""
        return len(self._readings)

    def take(self) -> list[Reading]:
        """The readings since the last call."""
        readings, self._readings[:] = list(self._readings), []
        return readings


@contextmanager
def lone_bus(line: BusLine[Any, Any], port: Port[Any, Any], clock: Clock) -> Iterator[LoneBus]:
    """The bus with its port open, while the context lasts. Raises PortError if it does not open."""
    bus = LoneBus(line, port, clock)
    try:
        bus.open()
        yield bus
    finally:
        bus.pump.close()
