"""USB devices for this machine's own kernel: the device's end of USB/IP, plugged into vhci_hcd.

The kernel takes one end of a socket pair and believes that a cable ends there; its drivers do the rest.
"""

import socket
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from echogrid.emulation.errors import EmulationError
from echogrid.emulation.wires.loop import Loop

VHCI = Path("/sys/devices/platform/vhci_hcd.0")

_FULL_SPEED = 2
_FREE = "004"
_SUBMIT, _UNLINK, _RETURNED, _UNLINKED = 1, 2, 3, 4
_HEADER = 48
_EPIPE, _ECONNRESET = 32, 104
_LARGEST_READ = 1 << 16
_PACKET = 64
_ENGLISH = b"\x04\x03\x09\x04"
_DEVICE, _CONFIGURATION, _STRING = 1, 2, 3
_GET_STATUS, _GET_DESCRIPTOR, _GET_CONFIGURATION, _GET_INTERFACE = 0, 6, 8, 10
_TO_HOST, _NOT_STANDARD = 0x80, 0x60


class UsbIpError(EmulationError, OSError):
    """The kernel takes no USB devices."""


@dataclass(frozen=True, slots=True)
class Identity:
    """What a device says of itself before it does anything."""

    vendor: int
    product: int
    release: int
    """Binary coded decimal; some drivers tell models apart by it."""
    manufacturer: str
    name: str
    serial: str
    endpoints: tuple[int, ...] = ()
    """Bulk; bit 7: to the host."""

    def descriptor(self, kind: int, index: int) -> bytes | None:
        """A standard descriptor; None if there is none."""
        if kind == _DEVICE:
            numbers = (self.vendor, self.product, self.release, 1, 2, 3, 1)
            return struct.pack("<BBHBBBBHHHBBBB", 18, _DEVICE, 0x0110, 0, 0, 0, _PACKET, *numbers)
        if kind == _CONFIGURATION:
            return self._configuration()
        if kind == _STRING:
            return self._string(index)
        return None

    def _configuration(self) -> bytes:
        ends = b"".join(struct.pack("<BBBBHB", 7, 5, end, 2, _PACKET, 0) for end in self.endpoints)
        interface = struct.pack("<9B", 9, 4, 0, 0, len(self.endpoints), 0xFF, 0xFF, 0xFF, 2)
        length = 9 + len(interface) + len(ends)
        return struct.pack("<BBHBBBBB", 9, _CONFIGURATION, length, 1, 1, 0, 0x80, 50) + interface + ends

    def _string(self, index: int) -> bytes | None:
        if index == 0:
            return _ENGLISH
        texts = (self.manufacturer, self.name, self.serial)
        if index > len(texts):
            return None
        text = texts[index - 1].encode("utf-16-le")
        return bytes((2 + len(text), _STRING)) + text


@dataclass(frozen=True, slots=True)
class Urb:
    """One request of the kernel: to read so many bytes at an endpoint, or to write these."""

    sequence: int
    endpoint: int
    reads: bool
    length: int
    data: bytes
    kind: int = 0
    """At endpoint 0, as the rest: the type of request."""
    request: int = 0
    value: int = 0
    index: int = 0


class Function(Protocol):
    """What makes a device more than a plug. It answers through the link, at once or later."""

    def control(self, urb: Urb) -> None:
        """A request of its class or vendor at endpoint 0."""
        ...

    def bulk(self, urb: Urb) -> None:
        """A transfer at another endpoint. One that reads may wait: see UsbIpLink.waiting."""
        ...


class UsbIpLink:
    """A device in a port of the kernel, until `unplug`. Served by the loop's thread."""

    def __init__(self, identity: Identity, function: Function, loop: Loop) -> None:
        """Plug it in. Raises UsbIpError."""
        self._identity = identity
        self._function = function
        self._loop = loop
        self._input = bytearray()
        self._pending: dict[int, Urb] = {}
        self._socket, kernels_end = socket.socketpair()
        with kernels_end:
            try:
                _attach(kernels_end)
            except OSError as error:
                self._socket.close()
                raise UsbIpError(f"{VHCI}: takes no device: {error} (modprobe vhci-hcd?)") from error
        self._plugged = True
        loop.watch(self._socket.fileno(), self._receive)

    def unplug(self) -> None:
        """Pull the cable. May be called twice."""
        if self._plugged:
            self._plugged = False
            self._loop.unwatch(self._socket.fileno())
            self._socket.close()
            self._pending.clear()

    def waiting(self, endpoint: int) -> Urb | None:
        """The oldest transfer that waits for data at an endpoint."""
        return next((urb for urb in self._pending.values() if urb.reads and urb.endpoint == endpoint), None)

    def answer(self, urb: Urb, data: bytes = b"") -> None:
        """Complete a request, with data if it reads; nothing if the kernel has withdrawn it."""
        sent = data[: urb.length] if urb.reads else b""
        self._return(urb, 0, len(sent) if urb.reads else len(urb.data), sent)

    def stall(self, urb: Urb) -> None:
        """Refuse a request."""
        self._return(urb, -_EPIPE, 0, b"")

    def _return(self, urb: Urb, status: int, length: int, data: bytes) -> None:
        if self._pending.pop(urb.sequence, None) is not None:
            head = struct.pack(">IIIIIiiiii8x", _RETURNED, urb.sequence, 0, 0, 0, status, length, 0, 0, 0)
            self._send(head + data)

    def _send(self, data: bytes) -> None:
        try:
            self._socket.sendall(data)
        except OSError:  # The kernel has let go of it.
            self.unplug()

    def _receive(self) -> None:
        try:
            chunk = self._socket.recv(_LARGEST_READ, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return
        except OSError:
            chunk = b""
        if not chunk:
            self.unplug()
            return
        self._input += chunk
        while self._plugged and self._next():
            pass

    def _next(self) -> bool:
        """Obey the first whole message; whether there was one."""
        if len(self._input) < _HEADER:
            return False
        command, sequence, _, reads, endpoint, fifth, length = struct.unpack_from(">IIIIIIi", self._input)
        size = _HEADER + (length if command == _SUBMIT and not reads else 0)
        if len(self._input) < size:
            return False
        message = bytes(self._input[:size])
        del self._input[:size]
        if command == _UNLINK:
            self._unlink(sequence, victim=fifth)
        else:
            setup = struct.unpack_from("<BBHH", message, 40)
            self._submit(Urb(sequence, endpoint, bool(reads), length, message[_HEADER:], *setup))
        return True

    def _unlink(self, sequence: int, victim: int) -> None:
        withdrawn = self._pending.pop(victim, None) is not None
        self._send(struct.pack(">IIIIIi24x", _UNLINKED, sequence, 0, 0, 0, -_ECONNRESET * withdrawn))

    def _submit(self, urb: Urb) -> None:
        self._pending[urb.sequence] = urb
        if urb.endpoint:
            self._function.bulk(urb)
        elif urb.kind & _NOT_STANDARD:
            self._function.control(urb)
        else:
            self._standard(urb)

    def _standard(self, urb: Urb) -> None:
        answers: dict[int, Callable[[], bytes | None]] = {
            _GET_STATUS: lambda: b"\0\0",
            _GET_DESCRIPTOR: lambda: self._identity.descriptor(urb.value >> 8, urb.value & 0xFF),
            _GET_CONFIGURATION: lambda: b"\1",
            _GET_INTERFACE: lambda: b"\0",
        }
        data = answers.get(urb.request, lambda: None)() if urb.kind & _TO_HOST else b""
        if data is None:
            self.stall(urb)
        else:
            self.answer(urb, data)


def _attach(kernels_end: socket.socket) -> None:
    """Hand the socket to a free port."""
    ports = [line.split() for line in (VHCI / "status").read_text().splitlines()]
    free = next((int(port[1]) for port in ports if port[0] == "hs" and port[2] == _FREE), None)
    if free is None:
        raise OSError("all its ports are taken")
    device = 1 << 16 | free + 1
    (VHCI / "attach").write_text(f"{free} {kernels_end.fileno()} {device} {_FULL_SPEED}")
