"""Where readings come from: one thread for each bus on the real clock."""

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, Self

from echogrid.drivers.device import Device, Health, State
from echogrid.drivers.readings import Reading
from echogrid.drivers.supervised import Supervised, beside
from echogrid.runtime.pump import PortState, Pump
from echogrid.runtime.reading_queue import ReadingQueue

_STACK_BYTES = 256 * 1024
_JOIN_S = 2.0


@dataclass(frozen=True, slots=True)
class DeviceReport:
    """How a device and its port are."""

    device: str
    bus: str
    health: Health


class Acquisition(Protocol):
    """Delivers readings to the loop."""

    def drain(self) -> list[Reading]:
        """What came in since the last call, in order of arrival."""
        ...

    def drain_overflow(self) -> list[Reading]:
        """What came in but had to give way since the last call."""
        ...

    def report(self, now_ns: int) -> list[DeviceReport]:
        """How every device is."""
        ...

    def stop(self) -> None:
        """Let the ports go; what came in before can still be drained. May be called twice."""
        ...


def device_reports(pumps: Sequence[Pump[Any, Any]], now_ns: int) -> list[DeviceReport]:
    """How every device of these buses is: a closed port is its devices' first trouble."""
    return [
        DeviceReport(device.name, pump.line.name, _health(pump, device, now_ns))
        for pump in pumps
        for device in pump.line.devices
    ]


def _health(pump: Pump[Any, Any], device: Device[Any, Any], now_ns: int) -> Health:
    try:
        health = device.health(now_ns)
        if isinstance(pump.port, Supervised):
            health = beside(health, pump.port.health(now_ns))
    except Exception as error:  # noqa: BLE001 - the loop must outlive any fault of a driver
        health = Health(State.INTERNAL, f"internal error: {error!r} (please report it)", {})
    counts = {**health.counts, **pump.line.counts, "port lost": pump.losses}
    if pump.state is PortState.CLOSED and pump.trouble:
        return Health(State.PORT_LOST, pump.trouble, counts)
    return Health(health.state, health.message, counts)


class ThreadedAcquisition:
    """A thread a bus, which owns its port. Enter to start, leave to stop them all."""

    def __init__(self, pumps: Sequence[Pump[Any, Any]], queue: ReadingQueue) -> None:
        self._pumps = pumps
        self._queue = queue
        self._stop = threading.Event()
        self._threads: list[threading.Thread] = []

    def __enter__(self) -> Self:
        previous = threading.stack_size(_STACK_BYTES)
        self._threads = [
            threading.Thread(target=self._run, args=(pump,), name=f"bus {pump.line.name}", daemon=True)
            for pump in self._pumps
        ]
        for thread in self._threads:
            thread.start()
        threading.stack_size(previous)
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def stop(self) -> None:
        """Let the ports go; what came in before can still be drained."""
        self._stop.set()
        for thread in self._threads:
            thread.join(_JOIN_S)

    def drain(self) -> list[Reading]:
        """What came in since the last call, in order of arrival."""
        return self._queue.drain()

    def drain_overflow(self) -> list[Reading]:
        """What came in but had to give way since the last call."""
        return self._queue.drain_overflow()

    def report(self, now_ns: int) -> list[DeviceReport]:
        """How every device is."""
        return device_reports(self._pumps, now_ns)

    def _run(self, pump: Pump[Any, Any]) -> None:
        while not self._stop.is_set():
            pump.turn()
        pump.close()
