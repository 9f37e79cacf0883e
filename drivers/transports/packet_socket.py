"""The client of an emulated bus in another process: a packet asks over a Unix socket, one answers."""

import os
import socket
from errno import ETIMEDOUT

from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.mend import cannot_open

LONGEST_PACKET = 1 << 17


class PacketSocket:
    """Asks one question at a time."""

    def __init__(self, kind: str, path: str, timeout_s: float) -> None:
        """`kind` is the bus's, for messages."""
        self._kind = kind
        self._path = path
        self._timeout_s = timeout_s
        self._socket: socket.socket | None = None

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        self.close()
        client = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        client.settimeout(self._timeout_s)
        try:
            client.connect(self._path)
        except OSError as error:
            client.close()
            kind = f"{self._kind} socket"
            raise cannot_open(kind, self._path, self._kind.lower(), error) from error
        self._socket = client

    def close(self) -> None:
        """Let go. May be called twice."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def ask(self, packet: bytes) -> bytes:
        """The answer. Raises PortError when the emulator is gone, OSError when it does not answer in time."""
        if self._socket is None:
            raise PortError(f"{self._path}: not open")
        lost = f"{self._path}: {self._kind} socket lost, did the emulator stop?"
        try:
            self._socket.sendall(packet)
            answer = self._socket.recv(LONGEST_PACKET)
        except TimeoutError:
            # A late answer must not be taken for the next one's.
            self.open()
            raise OSError(ETIMEDOUT, os.strerror(ETIMEDOUT)) from None
        except OSError as error:
            raise PortError(f"{lost} ({error})") from error
        if not answer:
            raise PortError(lost)
        return answer
