"""An emulated serial line: its devices, one host, and the time that bytes take between them."""

from collections import deque
from collections.abc import Sequence

from echogrid.drivers.bus import NEVER_NS, Break
from echogrid.emulation.buses.bus import PoweringBus
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.devices.transmitter import Transmitter

_KEPT = 4096
"""Bytes that wait for the host, as in a tty; later ones are lost."""
_BREAK_HEARD = b"\0"
"""What a receiver makes of a break."""


class SerialLine(PoweringBus[bytes, bytes | Break]):
    """A line with one device, whose port is the device's own: unplug either and the host loses the port.
    Or with several that speak only when they are spoken to: these may be unplugged one by one."""

    def __init__(self, name: str, *devices: SerialDevice) -> None:
        super().__init__(name, devices)
        first = devices[0]
        self.baud = first.baud
        self._devices: Sequence[SerialDevice] = devices
        self._one_wire = any(device.one_wire for device in devices)
        self._to_devices = Transmitter(first.baud, first.bits_per_byte)
        self._breaks: deque[int] = deque()
        self._received = bytearray()

    @property
    def present(self) -> bool:
        """Whether the host has the port."""
        return self._plugged and (len(self._devices) > 1 or self._devices[0].connected)

    @property
    def unplugs(self) -> int:
        """How often the host lost the port."""
        return self._unplugs + (self._devices[0].unplugs if len(self._devices) == 1 else 0)

    def lose_breaks(self) -> None:
        """Be carried by a wire on which no break shows: devices which need one do without."""
        for device in self._devices:
            device.needs_breaks = False

    def has_received(self) -> bool:
        """Whether bytes wait to be taken."""
        return bool(self._received)

    def _send(self, items: Sequence[bytes | Break], now_ns: int) -> None:
        """Send bytes and breaks to the devices."""
        for item in items:
            if isinstance(item, Break):
                self._breaks.append(self._to_devices.pause(now_ns, round(item.duration_s * 1e9)))
            else:
                self._to_devices.send(item, now_ns)

    def _take(self) -> tuple[bytes, ...]:
        """The bytes that have come by now, in one piece."""
        data = bytes(self._received)
        self._received.clear()
        return (data,)

    def _drop(self) -> None:
        self._to_devices.stop()
        self._breaks.clear()
        self._received.clear()

    def _next_ns(self) -> int:
        due_ns = min(self._to_devices.next_ns(), self._breaks[0] if self._breaks else NEVER_NS)
        for device in self._devices:
            due_ns = min(due_ns, device.next_event_ns(), device.output.next_ns())
        return due_ns

    def _step(self, now_ns: int) -> None:
        for device in self._devices:
            device.advance(now_ns)
            if sent := device.output.take(now_ns):
                self._received += sent
                for other in self._devices:
                    if other.has_contact(now_ns):
                        other.overhear(sent, now_ns)
        if self._breaks and now_ns >= self._breaks[0]:
            self._breaks.popleft()
            self._pass_on_break(now_ns)
        if data := self._to_devices.take(now_ns):
            self._pass_on(data, now_ns)
        del self._received[_KEPT:]

    def _pass_on(self, data: bytes, now_ns: int) -> None:
        if self._one_wire:
            self._received += data
        for device in self._devices:
            if device.has_contact(now_ns):
                device.receive(data, now_ns)

    def _pass_on_break(self, now_ns: int) -> None:
        if self._one_wire:
            self._received += _BREAK_HEARD
        for device in self._devices:
            if device.has_contact(now_ns):
                device.receive_break(now_ns)
