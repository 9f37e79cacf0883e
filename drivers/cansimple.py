"""ODrive's CANSimple protocol: what firmware 0.5 and 0.6 share."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from struct import Struct
from typing import Protocol

VERSION = 0x000
HEARTBEAT = 0x001
SET_STATE = 0x007
ESTIMATES = 0x009
COUNTS = 0x00A
SET_MODE = 0x00B
SET_VELOCITY = 0x00D
CLEAR_ERRORS = 0x018
COMMAND_BITS = 5
LENGTH = 8


class AxisState(IntEnum):
    """States in which the position may be zeroed, and in which it therefore does not count."""

    UNDEFINED = 0
    STARTUP = 2
    FULL_CALIBRATION = 3
    INDEX_SEARCH = 6
    OFFSET_CALIBRATION = 7
    HOMING = 11
    HALL_POLARITY_CALIBRATION = 12
    HALL_PHASE_CALIBRATION = 13


UNSETTLED = frozenset(AxisState)


class Heartbeat(Protocol):
    """What an axis says of itself, whatever its firmware."""

    @property
    def state(self) -> int:
        """What the axis does."""
        ...

    @property
    def expired(self) -> bool:
        """Whether its watchdog has let the motor go, and nothing else is wrong."""
        ...

    @property
    def trustworthy(self) -> bool:
        """Whether its position is a fact. An encoder without one is reported as standing at 0."""
        ...

    @property
    def zeroed(self) -> bool:
        """Whether it may have zeroed its position just now."""
        ...

    @property
    def unlike(self) -> bool:
        """Whether no axis of that firmware says so."""
        ...

    @property
    def unsettled(self) -> str:
        """What it is busy with while its position does not count; empty if it counts."""
        ...

    @property
    def faults(self) -> str:
        """Its errors by name; empty if there are none."""
        ...


@dataclass(frozen=True, slots=True)
class Version:
    """A firmware's version."""

    major: int
    minor: int
    revision: int

    def __str__(self) -> str:
        return f"{self.major}.{self.minor}.{self.revision}"


_ESTIMATES = Struct("<ff")
_COUNTS = Struct("<ii")


def decode_estimates(data: bytes) -> tuple[float, float]:
    """Position (turns) and velocity (turns/s) in the 8 bytes of the encoder's estimates."""
    position, velocity = _ESTIMATES.unpack(data)
    return position, velocity


def decode_counts(data: bytes) -> tuple[int, int]:
    """The count since power-up, which wraps at 2^31, and the one within the turn, in 8 bytes."""
    shadow, within = _COUNTS.unpack(data)
    return shadow, within


def decode_version(data: bytes) -> Version:
    """The firmware's version in the 8 bytes of an answer to Get_Version."""
    return Version(data[4], data[5], data[6])


def state_name(state: int) -> str:
    """The name of a state in which the position does not count; empty for others."""
    return AxisState(state).name if state in UNSETTLED else ""


def error_names(known: type[IntFlag], error: int) -> Iterator[str]:
    """The names of the bits of an axis error, and the number of those without."""
    for flag in known:
        if flag & error:
            yield flag.name or ""
            error &= ~flag.value
    if error:
        yield f"axis error {error:#x}"
