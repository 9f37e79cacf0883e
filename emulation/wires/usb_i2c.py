"""An I2C bus behind a USB adapter of the i2c-tiny-usb kind: to this machine's kernel a real /dev/i2c-N."""

import struct
from collections import deque
from collections.abc import Sequence

from echogrid.drivers.bus import I2cMessage, I2cResult, I2cTransfer
from echogrid.drivers.clock import Clock
from echogrid.emulation.buses.i2c_bus import I2cBus
from echogrid.emulation.wires.loop import Loop
from echogrid.emulation.wires.usbip import Identity, Urb, UsbIpLink
from echogrid.emulation.wires.wire import Wire

_GET_FUNCTIONS, _SET_DELAY, _GET_STATUS, _TRANSFER = 1, 2, 3, 4
_BEGIN_END = 3
"""Bits of a transfer's request; start and stop conditions, which the bus has at every message."""
_ACKNOWLEDGED, _NOT_ACKNOWLEDGED = 1, 2
_FUNCTIONS = 0x0EFF_0009
"""Plain transfers, and SMBus made of them (I2C_FUNC_I2C | I2C_FUNC_SMBUS_EMUL)."""


class UsbI2cWire(Wire[I2cResult, I2cTransfer]):
    """Carries a message at a time: the chips see a repeated start as a stop and a start."""

    def __init__(self, bus: I2cBus, serial: str, clock: Clock, loop: Loop) -> None:
        super().__init__(bus, clock, loop)
        self._identity = Identity(0x0403, 0xC631, 0x0205, "echogrid", "i2c-tiny-usb", serial)
        self._askers: deque[Urb] = deque()
        self._status = 0

    def control(self, urb: Urb) -> None:
        """One of the adapter's own requests."""
        if urb.request & ~_BEGIN_END == _TRANSFER:
            self._askers.append(urb)
            message = I2cMessage(urb.index, urb.data, urb.length if urb.reads else 0)
            self._send((I2cTransfer((message,)),))
        elif urb.request == _GET_FUNCTIONS:
            self._link.answer(urb, struct.pack("<I", _FUNCTIONS))
        elif urb.request == _GET_STATUS:
            self._link.answer(urb, bytes((self._status,)))
        elif urb.request == _SET_DELAY:
            self._link.answer(urb)
        else:
            self._link.stall(urb)

    def bulk(self, urb: Urb) -> None:
        """None: it has no such endpoint."""
        self._link.stall(urb)

    def _attach(self) -> None:
        self._link = UsbIpLink(self._identity, self, self._loop)

    def _detach(self) -> None:
        self._link.unplug()
        self._askers.clear()

    def _deliver(self, items: Sequence[I2cResult]) -> None:
        for result in items:
            urb = self._askers.popleft()
            self._status = _NOT_ACKNOWLEDGED if result.errno else _ACKNOWLEDGED
            self._link.answer(urb, result.data or b"\xff" * urb.length)
