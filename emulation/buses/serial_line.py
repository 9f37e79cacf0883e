"""An emulated serial line: one device, one host, and the time that bytes take between them."""

from collections.abc import Sequence

from echogrid.emulation.buses.bus import PoweringBus
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.devices.transmitter import Transmitter

_KEPT = 4096
"""Bytes that wait for the host, as in a tty; later ones are lost."""


class SerialLine(PoweringBus[bytes, bytes]):
    """A line whose port is the device's own: unplug either and the host loses the port."""

    def __init__(self, name: str, device: SerialDevice) -> None:
        super().__init__(name, (device,))
        self.baud = device.baud
        self._device = device
        self._to_device = Transmitter(device.baud)
        self._received = bytearray()

    @property
    def present(self) -> bool:
        """Whether the host has the port."""
        return self._plugged and self._device.connected

    @property
    def unplugs(self) -> int:
        """How often the host lost the port."""
        return self._unplugs + self._device.unplugs

    def has_received(self) -> bool:
        """Whether bytes wait to be taken."""
        return bool(self._received)

    def _send(self, items: Sequence[bytes], now_ns: int) -> None:
        """Send bytes to the device."""
        self._to_device.send(b"".join(items), now_ns)

    def _take(self) -> tuple[bytes, ...]:
        """The bytes that have come by now, in one piece."""
        data = bytes(self._received)
        self._received.clear()
        return (data,)

    def _drop(self) -> None:
        self._to_device.stop()
        self._received.clear()

    def _next_ns(self) -> int:
        return min(self._device.next_event_ns(), self._device.output.next_ns(), self._to_device.next_ns())

    def _step(self, now_ns: int) -> None:
        self._device.advance(now_ns)
        self._received += self._device.output.take(now_ns)
        del self._received[_KEPT:]
        data = self._to_device.take(now_ns)
        if data and self._device.powered:
            self._device.receive(data, now_ns)
