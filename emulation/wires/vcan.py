"""A CAN bus on a network interface of this machine's kernel, such as a virtual one (vcan)."""

import socket
import struct
from collections.abc import Sequence
from errno import EOPNOTSUPP
from pathlib import Path

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.clock import Clock
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.wires.loop import Loop
from echogrid.emulation.wires.wire import Wire

_FRAME = struct.Struct("=IB3x8s")
"""struct can_frame: identifier with flags, length, data."""
_FD_FRAME = struct.Struct("=IBB2x64s")
"""struct canfd_frame: identifier with flags, length, flags of CAN-FD, data. Its size is the least MTU."""
_BIT_RATE_SWITCH = 1
_INTERFACES = Path("/sys/class/net")


class VcanWire(Wire[CanFrame, CanFrame]):
    """The bus's nodes appear on the interface; unplugged, they fall silent and the interface stays."""

    def __init__(self, bus: CanBus, interface: str, clock: Clock, loop: Loop) -> None:
        super().__init__(bus, clock, loop)
        self._interface = interface
        self._fd = bus.fd

    def _attach(self) -> None:
        """Raises OSError, which names the mend if the interface takes no CAN-FD and a node speaks it."""
        if self._fd:
            require_fd(self._interface)
        self._socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        if self._fd:
            self._socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
        self._socket.setblocking(False)
        self._socket.bind((self._interface,))
        self._loop.watch(self._socket.fileno(), self._receive)

    def _detach(self) -> None:
        self._loop.unwatch(self._socket.fileno())
        self._socket.close()

    def _receive(self) -> None:
        try:
            while True:
                self._send((decode(self._socket.recv(_FD_FRAME.size)),))
        except OSError:  # EAGAIN: that was all; ENETDOWN: the interface is down.
            return

    def _deliver(self, items: Sequence[CanFrame]) -> None:
        for frame in items:
            try:
                self._socket.send(encode(frame))
            except OSError:  # The interface is down or full: the frame is lost, as on a real one.
                return


def require_fd(interface: str, interfaces: Path = _INTERFACES) -> None:
    """Raise OSError, which names the mend, if the interface takes no frames of CAN-FD."""
    if int((interfaces / interface / "mtu").read_text()) < _FD_FRAME.size:
        mend = f"sudo ip link set {interface} down && sudo ip link set {interface} mtu {_FD_FRAME.size} up"
        raise OSError(EOPNOTSUPP, f"{interface}: this CAN interface is set up without CAN-FD ({mend})")


def encode(frame: CanFrame) -> bytes:
    """A frame as the kernel takes it."""
    flags = socket.CAN_EFF_FLAG * frame.extended | socket.CAN_RTR_FLAG * frame.remote
    if frame.fd:
        return _FD_FRAME.pack(frame.identifier | flags, len(frame.data), _BIT_RATE_SWITCH, frame.data)
    return _FRAME.pack(frame.identifier | flags, len(frame.data), frame.data)


def decode(packet: bytes) -> CanFrame:
    """The kernel's frame. A request's length is not kept: CanFrame has no place for it."""
    fd = len(packet) == _FD_FRAME.size
    if fd:
        identifier, length, _, data = _FD_FRAME.unpack(packet)
    else:
        identifier, length, data = _FRAME.unpack(packet)
    extended, remote = bool(identifier & socket.CAN_EFF_FLAG), bool(identifier & socket.CAN_RTR_FLAG)
    mask = socket.CAN_EFF_MASK if extended else socket.CAN_SFF_MASK
    return CanFrame(identifier & mask, b"" if remote else data[:length], extended, remote, 0, fd)
