"""What crosses a bus, and the port that carries it: the only terms which drivers and emulators share."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

NEVER_NS = 1 << 62
"""A deadline that does not come."""
FD_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)
"""How many bytes a CAN-FD frame may have."""

In = TypeVar("In", covariant=True)
Out = TypeVar("Out", contravariant=True)
Transfer = TypeVar("Transfer")


@dataclass(frozen=True, slots=True)
class CanFrame:
    """One CAN frame, sent or received."""

    identifier: int
    data: bytes
    extended: bool = False
    remote: bool = False
    stamp_ns: int = 0
    """When it was received, CLOCK_MONOTONIC; 0 on frames to send."""
    fd: bool = False
    """A CAN-FD frame, of one of FD_LENGTHS, whose data go out at the faster bit rate."""


@dataclass(frozen=True, slots=True)
class I2cMessage:
    """One message of a transfer: bytes to write or, if there are none, a count of bytes to read."""

    address: int
    """7 bit."""
    write: bytes = b""
    read: int = 0


@dataclass(frozen=True, slots=True)
class I2cTransfer:
    """Messages which go out in one piece, as with I2C_RDWR."""

    messages: tuple[I2cMessage, ...]


@dataclass(frozen=True, slots=True)
class Break:
    """A serial line held low for longer than a byte takes."""

    duration_s: float


@dataclass(frozen=True, slots=True)
class SerialTransfer:
    """A request to a device on a serial line, and the reply to be waited for."""

    send: tuple[bytes | Break, ...]
    reply_length: Callable[[bytes], int] | None = None
    """How long the reply will be, by what has come of it; 0: that cannot be told yet. None: there is none."""
    within_ns: int = 0
    """For how long it is waited for, from the end of the request on."""
    echoed: bool = False
    """One wire for both directions: the host hears what it sends."""
    framed: bool = True
    """The reply shows by itself that it is whole, and whose; if not, a pause behind it does, and where
    another's reply may still come it is asked for once more."""
    quiet_ns: int = 0
    """So long the line is left in silence between the transfer before and this one."""


@dataclass(frozen=True, slots=True)
class IioRead:
    """An attribute of a device of the kernel's IIO subsystem, to be read."""

    device: str
    """Its folder (iio:device0), its label, its kernel driver or what it hangs on: a name that only it has."""
    attribute: str


@dataclass(frozen=True, slots=True)
class Result(Generic[Transfer]):
    """What became of a transfer."""

    transfer: Transfer
    start_ns: int
    end_ns: int
    data: bytes = b""
    """The bytes read: of an I2C transfer those of its messages, one after the other."""
    errno: int = 0
    """0, or why the transfer failed; a missing acknowledge is one of NACK_ERRNOS."""


@dataclass(frozen=True, slots=True)
class I2cResult(Result[I2cTransfer]):
    """What became of a transfer on I2C."""


@dataclass(frozen=True, slots=True)
class IioResult(Result[IioRead]):
    """What became of a read of the kernel's IIO subsystem; its data are the attribute's text."""


@dataclass(frozen=True, slots=True)
class SerialResult(Result[SerialTransfer]):
    """What became of a transfer on a serial line."""

    sent_ns: int = 0
    """When the request had passed."""


NACK_ERRNOS = frozenset({5, 6, 110, 121})
"""EIO, ENXIO, ETIMEDOUT, EREMOTEIO: which of them means "no acknowledge" differs by adapter."""


class Port(Protocol[In, Out]):
    """One end of a bus, owned by one thread.

    A serial port receives and sends chunks of bytes (and sends breaks), a CAN port frames; an I2C or IIO port
    sends transfers and receives their results.
    """

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        ...

    def close(self) -> None:
        """Let go. May be called twice."""
        ...

    def write(self, items: Sequence[Out]) -> None:
        """Send. Raises PortError when the port is lost."""
        ...

    def read(self, timeout_s: float) -> Sequence[In]:
        """What has come in; waits for something at most so long. Raises PortError when the port is lost."""
        ...
