"""A bus of emulated devices in another process: whole transfers over a Unix socket of packets."""

import os
import socket
from errno import EPROTO, ETIMEDOUT
from struct import Struct

from echogrid.drivers.bus import I2cMessage, I2cTransfer
from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.mend import cannot_open

COUNT = Struct("<B")
MESSAGE = Struct("<HHH")
"""Address, flags, length; followed by the data if it is written."""
REPLY = Struct("<iH")
"""errno, length; followed by the data."""
READ_FLAG = 1
LONGEST_REPLY = REPLY.size + 0xFFFF


def encode_request(transfer: I2cTransfer) -> bytes:
    """The packet which asks for the transfer."""
    return COUNT.pack(len(transfer.messages)) + b"".join(_encode(message) for message in transfer.messages)


def _encode(message: I2cMessage) -> bytes:
    if message.write:
        return MESSAGE.pack(message.address, 0, len(message.write)) + message.write
    return MESSAGE.pack(message.address, READ_FLAG, message.read)


def decode_reply(packet: bytes) -> bytes:
    """The bytes read. Raises OSError when the transfer failed or the packet is malformed."""
    if len(packet) < REPLY.size:
        raise OSError(EPROTO, os.strerror(EPROTO))
    errno, length = REPLY.unpack_from(packet)
    if errno:
        raise OSError(errno, os.strerror(abs(errno)))
    if len(packet) != REPLY.size + length:
        raise OSError(EPROTO, os.strerror(EPROTO))
    return packet[REPLY.size :]


class SocketAdapter:
    """The client of one emulated bus."""

    def __init__(self, path: str, timeout_s: float) -> None:
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
            raise cannot_open("I2C socket", self._path, "i2c", error, error.errno) from error
        self._socket = client

    def close(self) -> None:
        """Let go. May be called twice."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def transfer(self, transfer: I2cTransfer) -> bytes:
        """The bytes read. Raises PortError when the emulator is gone, OSError when the transfer failed."""
        if self._socket is None:
            raise PortError(f"{self._path}: not open")
        try:
            self._socket.sendall(encode_request(transfer))
            packet = self._socket.recv(LONGEST_REPLY)
        except TimeoutError:
            # A late reply must not be taken for the next one's.
            self.open()
            raise OSError(ETIMEDOUT, os.strerror(ETIMEDOUT)) from None
        except OSError as error:
            raise PortError(f"{self._path}: I2C socket lost, did the emulator stop? ({error})") from error
        if not packet:
            raise PortError(f"{self._path}: I2C socket lost, did the emulator stop?")
        return decode_reply(packet)
