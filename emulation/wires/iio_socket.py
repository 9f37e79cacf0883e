"""An emulated kernel's rangers as a Unix socket: one packet names a file to read, one brings what it says."""

import struct
from errno import EINVAL

from echogrid.drivers.bus import IioRead, IioResult
from echogrid.emulation.wires.packet_socket import PacketSocketWire

_ERRNO = struct.Struct("<i")


class IioSocketWire(PacketSocketWire[IioResult, IioRead]):
    """Its clients' reads go one after the other."""

    def _decode(self, packet: bytes) -> IioRead | None:
        return decode(packet)

    def _encode(self, result: IioResult) -> bytes:
        return encode(result.errno, result.data)

    def _refusal(self) -> bytes:
        return encode(EINVAL, b"")


def decode(packet: bytes) -> IioRead | None:
    """The read that a packet asks for, DEVICE/ATTRIBUTE; None if the packet is malformed."""
    try:
        device, slash, attribute = packet.decode().partition("/")
    except UnicodeDecodeError:
        return None
    return IioRead(device, attribute) if device and slash and attribute else None


def encode(errno: int, text: bytes) -> bytes:
    """The packet of a result."""
    return _ERRNO.pack(errno) + text
