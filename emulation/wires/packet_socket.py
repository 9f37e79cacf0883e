"""A bus as a Unix socket of packets: one asks for a transfer, one brings its result."""

import socket
from abc import abstractmethod
from collections import deque
from collections.abc import Sequence
from pathlib import Path

from echogrid.drivers.clock import Clock
from echogrid.emulation.buses.bus import Bus
from echogrid.emulation.wires.loop import Loop
from echogrid.emulation.wires.unix_socket import listen
from echogrid.emulation.wires.wire import In, Out, Wire

_LARGEST_PACKET = 1 << 16


class PacketSocketWire(Wire[In, Out]):
    """Serves any number of clients. The bus gives the results in the order of the transfers."""

    def __init__(self, bus: Bus[In, Out], path: Path, clock: Clock, loop: Loop) -> None:
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

    def _deliver(self, items: Sequence[In]) -> None:
        for result in items:
            self._reply(self._askers.popleft(), self._encode(result))

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
        transfer = self._decode(packet)
        if transfer is None:
            self._reply(client, self._refusal())
            return
        self._askers.append(client)
        self._send((transfer,))

    def _reply(self, client: socket.socket, packet: bytes) -> None:
        if self._clients.get(client.fileno()) is not client:
            return
        try:
            client.send(packet)
        except OSError:  # It has gone, or asks without reading.
            self._dismiss(client)

    def _dismiss(self, client: socket.socket) -> None:
        del self._clients[client.fileno()]
        self._loop.unwatch(client.fileno())
        client.close()

    @abstractmethod
    def _decode(self, packet: bytes) -> Out | None:
        """The transfer that a packet asks for; None if the packet is malformed."""

    @abstractmethod
    def _encode(self, result: In) -> bytes:
        """The packet of a result."""

    @abstractmethod
    def _refusal(self) -> bytes:
        """The packet which says that the one that came is malformed."""
