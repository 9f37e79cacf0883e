"""What drivers of chips on I2C share: registers read and written as courses, and the moment of a command."""

from dataclasses import dataclass

from echogrid.drivers.bus import I2cMessage, I2cTransfer, Result
from echogrid.drivers.course import Course
from echogrid.drivers.device import State
from echogrid.drivers.make import Fired, Trouble

TRIES = 8
"""Of ten transfers seven may be disturbed: then a ping of six still comes about, mostly."""
QUICK_NS = 5_000_000
"""No message is so long on the wire: an adapter that takes longer has waited for nobody."""


def require_address(address: int, lowest: int = 0x08, highest: int = 0x77) -> None:
    """Raise ValueError for an address (7 bit) that a chip can't have; the others are reserved on I2C."""
    if not lowest <= address <= highest:
        raise ValueError(f"address is {address:#04x}: expected {lowest:#04x} to {highest:#04x} (7 bit)")


@dataclass(frozen=True, slots=True)
class Chip:
    """One address on the bus."""

    address: int
    """7 bit."""
    tries: int = 1
    """How often a message is sent before its missing acknowledge counts."""

    @property
    def where(self) -> str:
        """For messages."""
        return f"{self.address:#04x} (7 bit)"

    @property
    def insisting(self) -> "Chip":
        """The same, for messages that it should acknowledge at any time: a disturbed one is sent again."""
        return Chip(self.address, TRIES)

    @property
    def idle(self) -> I2cTransfer:
        """A transfer of nothing."""
        return I2cTransfer(())

    def missing(self) -> Trouble:
        """That nobody acknowledges."""
        return Trouble(
            State.MISSING, f"no answer at {self.where}: check its power, wires and address (echogrid scan)"
        )

    def send(self, data: bytes) -> Course[I2cTransfer, Result[I2cTransfer]]:
        """Write bytes."""
        return (yield from self._transfer(I2cMessage(self.address, write=data)))

    def write(self, register: int, *values: int) -> Course[I2cTransfer, Result[I2cTransfer]]:
        """Write a register and those after it."""
        return (yield from self.send(bytes((register, *values))))

    def take(self, count: int) -> Course[I2cTransfer, bytes]:
        """Read without naming a register; nothing when the chip does not acknowledge."""
        result = yield from self.receive(count)
        return b"" if result.errno else result.data

    def receive(self, count: int) -> Course[I2cTransfer, Result[I2cTransfer]]:
        """The same, with its times."""
        return (yield from self._transfer(I2cMessage(self.address, read=count)))

    def read(self, register: int, count: int) -> Course[I2cTransfer, bytes]:
        """Read registers; nothing when the chip does not acknowledge.

        Pointer and read go out as two transfers: behind a repeated start some masters read on
        without an acknowledge, and return garbage.
        """
        pointed = yield from self.send(bytes((register,)))
        if pointed.errno:
            return b""
        return (yield from self.take(count))

    def _transfer(self, message: I2cMessage) -> Course[I2cTransfer, Result[I2cTransfer]]:
        """Send it, again if need be; an adapter that takes long to see that nobody answers is asked once."""
        for _ in range(self.tries - 1):
            result = yield I2cTransfer((message,))
            if not result.errno or result.end_ns - result.start_ns > QUICK_NS:
                return result
        return (yield I2cTransfer((message,)))


GENERAL_CALL = Chip(0)
"""All chips which obey it."""


def fired(result: Result[I2cTransfer], resolution_ns: int) -> Fired:
    """The ping that a command started: in the middle of the transfer, give or take half of it."""
    error_ns = (result.end_ns - result.start_ns + 1) // 2 + resolution_ns
    trouble = "no acknowledge" if result.errno else ""
    return Fired((result.start_ns + result.end_ns) // 2, error_ns, trouble)


def overheard(result: Result[I2cTransfer], command: bytes, resolution_ns: int) -> Fired | None:
    """The ping that a general call of this command started; None if the transfer is something else."""
    if result.errno or result.transfer.messages != (I2cMessage(GENERAL_CALL.address, write=command),):
        return None
    return fired(result, resolution_ns)
