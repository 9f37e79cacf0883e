"""An emulated chip on an I2C bus."""

from abc import abstractmethod
from typing import ClassVar

from echogrid.emulation.devices.device import EmulatedDevice


class I2cChip(EmulatedDevice):
    """Answers to its address. A message reaches it whole, at its end; a read is answered at its beginning."""

    takes_general_call: ClassVar[bool] = False
    """Whether it obeys messages to address 0."""

    def __init__(self, name: str, address: int) -> None:
        super().__init__(name)
        self.address = address

    @abstractmethod
    def acknowledges(self, now_ns: int) -> bool:
        """Whether it would acknowledge its address now."""

    @abstractmethod
    def write(self, data: bytes, now_ns: int) -> None:
        """Take a message."""

    @abstractmethod
    def read(self, count: int) -> bytes:
        """Give so many bytes."""
