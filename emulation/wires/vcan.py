"""A CAN bus on a network interface of this machine's kernel, such as a virtual one (vcan)."""

import socket
import struct
from collections.abc import Sequence

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.clock import Clock
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.wires.loop import Loop
from echogrid.emulation.wires.wire import Wire

_FRAME = struct.Struct("=IB3x8s")
"""struct can_frame: identifier with flags, length, data."""


class VcanWire(Wire[CanFrame, CanFrame]):
    """The bus's nodes appear on the interface; unplugged, they fall silent and the interface stays."""

    def __init__(self, bus: CanBus, interface: str, clock: Clock, loop: Loop) -> None:
        super().__init__(bus, clock, loop)
        self._interface = interface

    def _attach(self) -> None:
        self._socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self._socket.setblocking(False)
        self._socket.bind((self._interface,))
        self._loop.watch(self._socket.fileno(), self._receive)

    def _detach(self) -> None:
        self._loop.unwatch(self._socket.fileno())
        self._socket.close()

    def _receive(self) -> None:
        try:
            while True:
                self._send((decode(self._socket.recv(_FRAME.size)),))
        except OSError:  # EAGAIN: that was all; ENETDOWN: the interface is down.
            return

    def _deliver(self, items: Sequence[CanFrame]) -> None:
        for frame in items:
            try:
                self._socket.send(encode(frame))
            except OSError:  # The interface is down or full: the frame is lost, as on a real one.
                return


def encode(frame: CanFrame) -> bytes:
    """A frame as the kernel takes it."""
    flags = socket.CAN_EFF_FLAG * frame.extended | socket.CAN_RTR_FLAG * frame.remote
    return _FRAME.pack(frame.identifier | flags, len(frame.data), frame.data)


def decode(packet: bytes) -> CanFrame:
    """The kernel's frame. A request's length is not kept: CanFrame has no place for it."""
    identifier, length, data = _FRAME.unpack(packet)
    extended, remote = bool(identifier & socket.CAN_EFF_FLAG), bool(identifier & socket.CAN_RTR_FLAG)
    mask = socket.CAN_EFF_MASK if extended else socket.CAN_SFF_MASK
    return CanFrame(identifier & mask, b"" if remote else data[:length], extended, remote)
