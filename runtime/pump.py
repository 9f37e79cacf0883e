"""One bus: its port opened, kept open and opened again, and its devices stepped with what it brings."""

from collections.abc import Callable
from contextlib import suppress
from enum import Enum
from typing import Generic, TypeVar

from echogrid.drivers.bus import Port
from echogrid.drivers.clock import Clock
from echogrid.drivers.device import BusLine
from echogrid.drivers.errors import PortError
from echogrid.drivers.readings import Reading

In = TypeVar("In")
Out = TypeVar("Out")

_LONGEST_WAIT_NS = 50_000_000
_BACK_OFF_NS = (100_000_000, 200_000_000, 500_000_000, 1_000_000_000)


class PortState(Enum):
    """How the port is."""

    CLOSED = "closed"
    OPEN = "open"


class Pump(Generic[In, Out]):
    """Owns a port and a line of devices. `turn` is called again and again by the bus's thread, or by the
    simulation when something is due."""

    def __init__(
        self,
        line: BusLine[In, Out],
        port: Port[In, Out],
        clock: Clock,
        deliver: Callable[[tuple[Reading, ...]], None],
    ) -> None:
        self.line = line
        self.port = port
        self.state = PortState.CLOSED
        self.trouble = ""
        """Why the port is closed, in the port's own words."""
        self.losses = 0
        self.due_ns = 0
        """When a turn is wanted even if nothing comes in."""
        self._clock = clock
        self._deliver = deliver
        self._attempts = 0

    def turn(self) -> None:
        """Open the port if it is closed; else take what came in, step the devices and send what they want."""
        try:
            if self.state is PortState.OPEN:
                self._exchange()
            elif self._clock.now_ns() >= self.due_ns:
                self._open()
            else:
                self._clock.sleep_until_ns(min(self.due_ns, self._clock.now_ns() + _LONGEST_WAIT_NS))
        except PortError as error:
            self._lost(str(error))
        except Exception as error:  # noqa: BLE001 - a bus must outlive any fault of a driver, seen in its health
            self._lost(_internal(self.line.name, error))

    def close(self) -> None:
        """Say what is to be sent last, if it still can be, and let the port go."""
        try:
            if self.state is PortState.OPEN and (parting := self.line.parting(self._clock.now_ns())):
                with suppress(PortError):
                    self.port.write(parting)
        finally:
            self.port.close()
        self.state = PortState.CLOSED

    def _open(self) -> None:
        self.port.open()
        self.state, self.trouble, self._attempts = PortState.OPEN, "", 0
        self.due_ns = self._clock.now_ns()

    def _exchange(self) -> None:
        wait_ns = min(self.due_ns - self._clock.now_ns(), _LONGEST_WAIT_NS)
        received = self.port.read(max(wait_ns, 0) * 1e-9)
        step = self.line.step(self._clock.now_ns(), received)
        self._deliver(step.readings)
        self.due_ns = step.deadline_ns
        if step.send:
            self.port.write(step.send)

    def _lost(self, trouble: str) -> None:
        """Close the port and try again later, each time a little later."""
        now_ns = self._clock.now_ns()
        if self.state is PortState.OPEN:
            self.losses += 1
        self.state, self.trouble = PortState.CLOSED, trouble
        self.due_ns = now_ns + _BACK_OFF_NS[min(self._attempts, len(_BACK_OFF_NS) - 1)]
        self._attempts += 1
        try:
            self.close()
            self.line.lost(now_ns)
        except Exception as error:  # noqa: BLE001 - as above
            self.trouble = _internal(self.line.name, error)


def _internal(bus: str, error: Exception) -> str:
    return f"{bus}: internal error: {error!r} (please report it)"
