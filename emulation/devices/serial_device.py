"""An emulated device at the end of a serial line."""

from abc import abstractmethod

from echogrid.emulation.devices.device import EmulatedDevice
from echogrid.emulation.devices.transmitter import Transmitter


class SerialDevice(EmulatedDevice):
    """Sends through `output`, whose bytes take their time on the wire."""

    def __init__(self, name: str, baud: int) -> None:
        super().__init__(name)
        self.baud = baud
        self.output = Transmitter(baud)

    @abstractmethod
    def receive(self, data: bytes, now_ns: int) -> None:
        """Take bytes from the host, whose last one has just passed."""
