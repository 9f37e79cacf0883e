"""Emulated IIO devices in another process: whole reads over a Unix socket of packets."""

import os
from errno import EPROTO
from struct import Struct

from echogrid.drivers.bus import IioRead
from echogrid.drivers.transports.packet_socket import PacketSocket

ERRNO = Struct("<i")
"""What a reply begins with; the text follows."""
WITHIN_S = 0.5
"""The kernel's own rangers take at most 0.2 s."""


def encode_request(transfer: IioRead) -> bytes:
    """The packet which asks for the attribute."""
    return f"{transfer.device}/{transfer.attribute}".encode()


def decode_reply(packet: bytes) -> bytes:
    """The attribute's text. Raises OSError when the read failed or the packet is malformed."""
    if len(packet) < ERRNO.size:
        raise OSError(EPROTO, os.strerror(EPROTO))
    (errno,) = ERRNO.unpack_from(packet)
    if errno:
        raise OSError(errno, f"the read failed with {errno}")
    return packet[ERRNO.size :]


class SocketAdapter(PacketSocket):
    """The client of one emulated kernel."""

    def __init__(self, path: str, timeout_s: float = WITHIN_S) -> None:
        super().__init__("IIO", path, timeout_s)

    def transfer(self, transfer: IioRead) -> bytes:
        """The attribute's text. Raises PortError when the emulator is gone, OSError when the read failed."""
        return decode_reply(self.ask(encode_request(transfer)))
