"""An emulated device at the end of a serial line."""

from abc import abstractmethod
from typing import ClassVar

from echogrid.emulation.devices.device import EmulatedDevice
from echogrid.emulation.devices.transmitter import Transmitter


class SerialDevice(EmulatedDevice):
    """Sends through `output`, whose bytes take their time on the wire."""

    shares_line: ClassVar[bool] = False
    """Whether others may be on the same line: it speaks only when it is spoken to."""
    one_wire: bool = False
    """Whether the host hears what it sends, because there is one wire for both directions."""

    def __init__(self, name: str, baud: int, bits_per_byte: int = 10) -> None:
        """`bits_per_byte` counts start, data, parity and stop bits."""
        super().__init__(name)
        self.baud = baud
        self.bits_per_byte = bits_per_byte
        self.output = Transmitter(baud, bits_per_byte)
        self.needs_breaks = False
        """Whether it listens only behind a break."""

    def send(self, data: bytes, start_ns: int) -> None:
        """Send from that time on, unless its contact is bad then."""
        if self.has_contact(start_ns):
            self.output.send(data, start_ns)

    @abstractmethod
    def receive(self, data: bytes, now_ns: int) -> None:
        """Take bytes from the host, whose last one has just passed. Called with power and contact only."""

    def receive_break(self, now_ns: int) -> None:
        """Take a break, which has just ended."""

    def overhear(self, data: bytes, now_ns: int) -> None:
        """Take bytes that a device on the line, oneself too, has sent, as in `receive`."""
