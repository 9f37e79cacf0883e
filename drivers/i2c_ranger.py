"""What makes of rangers on I2C share which one message fires, and which know no general call."""

from echogrid.drivers.bus import I2cTransfer, Result
from echogrid.drivers.commanded import Fired
from echogrid.drivers.course import Course
from echogrid.drivers.i2c_chip import Chip, fired


class OneMessageMake:
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

    def fire_all(self) -> Course[I2cTransfer, Fired]:
        """Start this one's own ping."""
        return (yield from self.fire(listens=False))

    def called(self, result: Result[I2cTransfer]) -> Fired | None:
        """Nothing that another one does fires it."""
        del result
        return None
