"""An emulated kernel with rangers at its pins and chips: one file is read after the other."""

from collections import deque
from collections.abc import Sequence
from errno import ENODEV

from echogrid.drivers.bus import NEVER_NS, IioRead, IioResult
from echogrid.emulation.buses.bus import Bus
from echogrid.emulation.devices.iio_device import IioDevice, Reply

_LOOK_NS = 20_000
"""To find out that there is no such device."""


class IioBus(Bus[IioResult, IioRead]):
    """Reads wait for each other, as those of one thread do. Unplugged, the kernel's drivers are unloaded:
    the rangers keep their supply."""

    def __init__(self, name: str, devices: Sequence[IioDevice]) -> None:
        super().__init__(name, devices)
        self._rangers = {device.device: device for device in devices}
        self._waiting: deque[IioRead] = deque()
        self._reading: IioRead | None = None
        self._begun_ns = 0
        self._nobody_ns = NEVER_NS
        """When a read ends whose device is not there."""
        self._received: list[IioResult] = []

    def has_received(self) -> bool:
        """Whether results wait to be taken."""
        return bool(self._received)

    def _send(self, items: Sequence[IioRead], now_ns: int) -> None:
        """Begin reads, each when the one before has ended."""
        self._waiting.extend(items)
        self._begin_next(now_ns)

    def _take(self) -> tuple[IioResult, ...]:
        """The results of the reads that have ended by now."""
        results = tuple(self._received)
        self._received.clear()
        return results

    def _drop(self) -> None:
        self._waiting.clear()
        self._received.clear()
        if self._reading and (ranger := self._rangers.get(self._reading.device)):
            ranger.abandon()
        self._reading, self._nobody_ns = None, NEVER_NS

    def _next_ns(self) -> int:
        return min((self._nobody_ns, *(ranger.next_event_ns() for ranger in self._rangers.values())))

    def _step(self, now_ns: int) -> None:
        for ranger in self._rangers.values():
            ranger.advance(now_ns)
        if self._reading and (reply := self._reply(self._reading, now_ns)):
            self._received.append(IioResult(self._reading, self._begun_ns, now_ns, reply.text, reply.errno))
            self._reading = None
            self._begin_next(now_ns)

    def _begin_next(self, now_ns: int) -> None:
        if self._reading or not self._waiting:
            return
        self._reading, self._begun_ns = self._waiting.popleft(), now_ns
        ranger = self._rangers.get(self._reading.device)
        if ranger is not None and ranger.connected:
            ranger.begin(self._reading.attribute, now_ns)
        else:
            self._nobody_ns = now_ns + _LOOK_NS

    def _reply(self, reading: IioRead, now_ns: int) -> Reply | None:
        if now_ns >= self._nobody_ns:
            self._nobody_ns = NEVER_NS
            return Reply(errno=ENODEV)
        ranger = self._rangers.get(reading.device)
        return ranger.take_reply() if ranger else None
