"""An I2C bus as a Unix socket: one packet carries the messages of a transfer, one brings its result."""

import struct
from errno import EINVAL

from echogrid.drivers.bus import I2cMessage, I2cResult, I2cTransfer
from echogrid.emulation.wires.packet_socket import PacketSocketWire

_MESSAGE = struct.Struct("<HHH")
_REPLY = struct.Struct("<iH")
_READ_FLAG = 1


class I2cSocketWire(PacketSocketWire[I2cResult, I2cTransfer]):
    """Its clients' transfers go over the bus one after the other."""

    def _decode(self, packet: bytes) -> I2cTransfer | None:
        return decode(packet)

    def _encode(self, result: I2cResult) -> bytes:
        return encode(result.errno, result.data)

    def _refusal(self) -> bytes:
        return encode(EINVAL, b"")


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
