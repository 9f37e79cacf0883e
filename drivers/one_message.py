"""What makes of rangers on I2C share which one message fires, and which know no general call."""

from echogrid.drivers.bus import I2cTransfer
from echogrid.drivers.course import Course
from echogrid.drivers.i2c_chip import Chip, fired
from echogrid.drivers.make import Fired, Make


class OneMessageMake(Make[I2cTransfer]):
    """The half of a make that is alike in all of them."""

    def __init__(self, address: int, command: bytes, resolution_ns: int) -> None:
        """`command` fires the ranger at that 7-bit address; `resolution_ns` is how finely it tells times."""
        self._chip = Chip(address)
        self.where = self._chip.where
        self.idle = self._chip.idle
        self._command = command
        self._resolution_ns = resolution_ns

    def fire(self, listens: bool) -> Course[I2cTransfer, Fired]:
        """Start a ping; none of them can listen without one."""
        del listens
        return fired((yield from self._chip.insisting.send(self._command)), self._resolution_ns)
