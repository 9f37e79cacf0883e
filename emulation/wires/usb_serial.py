"""A serial line behind a USB adapter of FTDI's kind: to this machine's kernel a real /dev/ttyUSBn."""

from collections.abc import Sequence
from random import Random

from echogrid.drivers.bus import Break
from echogrid.drivers.clock import Clock
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.wires.loop import Loop
from echogrid.emulation.wires.usbip import Identity, Urb, UsbIpLink
from echogrid.emulation.wires.wire import Wire

_TO_HOST, _FROM_HOST = 0x81, 0x02
_RESET, _SET_BAUD, _GET_MODEM_STATUS, _GET_LATENCY = 0, 3, 5, 10
_CLOCK = 3_000_000
"""What the divisor divides."""
_EIGHTHS = (0, 4, 2, 1, 3, 5, 6, 7)
"""The divisor's fraction, by the code that stands for it."""
_STATUS = b"\x01\x60"
"""Before the bytes of each packet: the modem's lines; transmitter empty."""
_PAYLOAD = 62
_KEPT = 256
"""The chip's own buffer: bytes wait there for the host, later ones are lost."""
_TOLERANCE = 0.03
"""How far off the speed may be: half a bit in ten and a half, less some for both sides."""


class UsbSerialWire(Wire[bytes, bytes | Break]):
    """A serial line whose client must set the right speed: else both sides read garbage."""

    def __init__(self, line: SerialLine, serial: str, clock: Clock, loop: Loop, random: Random) -> None:
        super().__init__(line, clock, loop)
        line.lose_breaks()
        ends = (_TO_HOST, _FROM_HOST)
        self._identity = Identity(0x0403, 0x6001, 0x0600, "echogrid", "serial ranger", serial, ends)
        self._line_baud = line.baud
        self._random = random
        self._output = bytearray()
        self.baud: int | None = None
        """What the client has set; None before it did."""

    def control(self, urb: Urb) -> None:
        """One of the adapter's own requests; what has no meaning here is taken and forgotten."""
        if urb.request == _SET_BAUD:
            self.baud = _baud(urb.value, urb.index)
        elif urb.request == _RESET:
            self._output.clear()
        answers = {_GET_MODEM_STATUS: _STATUS, _GET_LATENCY: b"\x01"}
        self._link.answer(urb, answers.get(urb.request, b"\xff" * urb.length))

    def bulk(self, urb: Urb) -> None:
        """Bytes from the client, or its wish to have some."""
        if urb.reads:
            self._hand_over()
        else:
            self._link.answer(urb)
            self._send((self._heard(urb.data),))

    def _attach(self) -> None:
        self.baud = None
        self._output.clear()
        self._link = UsbIpLink(self._identity, self, self._loop)

    def _detach(self) -> None:
        self._link.unplug()

    def _deliver(self, items: Sequence[bytes]) -> None:
        self._output += self._heard(b"".join(items))
        del self._output[_KEPT:]
        self._hand_over()

    def _hand_over(self) -> None:
        while self._output and (urb := self._link.waiting(_TO_HOST & 0x7F)):
            self._link.answer(urb, _STATUS + self._output[:_PAYLOAD])
            del self._output[:_PAYLOAD]

    def _heard(self, data: bytes) -> bytes:
        """The bytes as they are read at the other side."""
        if self.baud is not None and abs(self.baud - self._line_baud) <= _TOLERANCE * self._line_baud:
            return data
        return self._random.randbytes(len(data))


def _baud(value: int, index: int) -> int:
    """The speed by the divisor that a request carries: 14 bits, and a code for the eighths."""
    eighths = (value & 0x3FFF) * 8 + _EIGHTHS[value >> 14 | (index & 1) << 2]
    return _CLOCK if eighths < 8 else 2_000_000 if eighths == 8 else round(_CLOCK * 8 / eighths)
