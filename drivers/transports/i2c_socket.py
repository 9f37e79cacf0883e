"""A bus of emulated devices in another process: whole transfers over a Unix socket of packets."""

import os
from errno import EPROTO
from struct import Struct

from echogrid.drivers.bus import I2cMessage, I2cTransfer
from echogrid.drivers.transports.packet_socket import PacketSocket

COUNT = Struct("<B")
MESSAGE = Struct("<HHH")
"""Address, flags, length; followed by the data if it is written."""
REPLY = Struct("<iH")
"""errno, length; followed by the data."""
READ_FLAG = 1


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


class SocketAdapter(PacketSocket):
    """The client of one emulated bus."""

    def __init__(self, path: str, timeout_s: float) -> None:
        super().__init__("I2C", path, timeout_s)

    def transfer(self, transfer: I2cTransfer) -> bytes:
        """The bytes read. Raises PortError when the emulator is gone, OSError when the transfer failed."""
        return decode_reply(self.ask(encode_request(transfer)))
