"""An I2C bus as a Unix socket: one packet carries the messages of a transfer, one brings its result."""

import socket
import struct
from collections import deque
from collections.abc import Sequence
from errno import EINVAL
from pathlib import Path

from echogrid.drivers.bus import I2cMessage, I2cResult, I2cTransfer
from echogrid.drivers.clock import Clock
from echogrid.emulation.buses.i2c_bus import I2cBus
from echogrid.emulation.wires.loop import Loop
from echogrid.emulation.wires.unix_socket import listen
from echogrid.emulation.wires.wire import Wire

_MESSAGE = struct.Struct("<HHH")
_REPLY = struct.Struct("<iH")
_READ_FLAG = 1
_LARGEST_PACKET = 1 << 16


class I2cSocketWire(Wire[I2cResult, I2cTransfer]):
    """Serves any number of clients; their transfers go over the bus one after the other."""

    def __init__(self, bus: I2cBus, path: Path, clock: Clock, loop: Loop) -> None:
        super().__init__(bus, clock, loop)
        self._path = path
        self._clients: dict[int, socket.socket] = {}
        self._askers: deque[socket.socket] = deque()

    def _attach(self) -> None:
        self._listener = listen(self._path, socket.SOCK_SEQPACKET)
        self._loop.watch(self._listener.fileno(), self._accept)

    def _detach(self) -> None:
        self._path.unlink(missing_ok=True)
        self._loop.unwatch(self._listener.fileno())
        self._listener.close()
        for client in tuple(self._clients.values()):
            self._dismiss(client)
        self._askers.clear()

    def _deliver(self, items: Sequence[I2cResult]) -> None:
        for result in items:
            self._reply(self._askers.popleft(), result.errno, result.data)

    def _accept(self) -> None:
        try:
            client, _ = self._listener.accept()
        except OSError:  # It has gone again.
            return
        client.setblocking(False)
        self._clients[client.fileno()] = client
        self._loop.watch(client.fileno(), lambda: self._receive(client))

    def _receive(self, client: socket.socket) -> None:
        try:
            packet = client.recv(_LARGEST_PACKET)
        except OSError:
            packet = b""
        if not packet:
            self._dismiss(client)
            return
        transfer = decode(packet)
        if transfer is None:
            self._reply(client, EINVAL, b"")
            return
        self._askers.append(client)
        self._send((transfer,))

    def _reply(self, client: socket.socket, errno: int, data: bytes) -> None:
        if self._clients.get(client.fileno()) is not client:
            return
        try:
            client.send(encode(errno, data))
        except OSError:  # It has gone, or asks without reading.
            self._dismiss(client)

    def _dismiss(self, client: socket.socket) -> None:
        del self._clients[client.fileno()]
        self._loop.unwatch(client.fileno())
        client.close()


def decode(packet: bytes) -> I2cTransfer | None:
    """The transfer that a packet asks for; None if the packet is malformed."""
    messages: list[I2cMessage] = []
    offset = 1
    try:
        for _ in range(packet[0]):
            address, flags, length = _MESSAGE.unpack_from(packet, offset)
            offset += _MESSAGE.size
            if flags & _READ_FLAG:
                messages.append(I2cMessage(address, read=length))
            else:
                messages.append(I2cMessage(address, write=packet[offset : offset + length]))
                offset += length
    except struct.error:
        return None
    return I2cTransfer(tuple(messages)) if offset == len(packet) and messages else None


def encode(errno: int, data: bytes) -> bytes:
    """The packet of a result."""
    return _REPLY.pack(errno, len(data)) + data
