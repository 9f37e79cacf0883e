"""What the robot asks of a device, whatever its make: its name, its limits, its turn to fire."""

from dataclasses import dataclass
from enum import Enum
from math import pi

from echogrid.drivers.throttle import Throttle

_MIX = 0x9E37_79B9_7F4A_7C15
_MASK = (1 << 64) - 1


@dataclass(frozen=True, slots=True)
class Turn:
    """One time to fire."""

    start_ns: int
    listens: bool = False
    """Do all but ping: what is heard then is not one's own."""
    number: int = 0
    """Of all turns since the clock's zero."""


@dataclass(frozen=True, slots=True)
class Slot:
    """A commanded ranger's turns: every `period_ns`, `offset_ns` after the clock's zero, and a little later
    by the turn's own delay.

    Slots of several rangers keep their order and gaps across buses with no talk between them,
    because all are counted on the same clock.
    """

    period_ns: int
    offset_ns: int
    delays_ns: tuple[int, ...] = (0,)
    """What is added to the turns, in rotation: with two that alternate, what one hears of others alternates,
    too (EERUF, Borenstein & Koren 1995)."""
    jitter_ns: int = 0
    """Up to so much more, by chance, so that foreign robots don't keep step. With the delay it is less than
    the period."""
    listens_every: int = 0
    """Every so many turns it only listens; 0: never."""
    listens_first: int = 0
    """The number of one of these turns, so that not all rangers listen at once."""
    seed: int = 0
    """Of the chance: slots of one period and one seed are late by the same in their turns of one number."""

    def next_turn(self, after_ns: int) -> Turn:
        """The first turn later than `after_ns`."""
        number = (after_ns - self.offset_ns) // self.period_ns
        while (start_ns := self._start_ns(number)) <= after_ns:
            number += 1
        listens = self.listens_every > 0 and (number - self.listens_first) % self.listens_every == 0
        return Turn(start_ns, listens, number)

    def planned_ns(self, number: int) -> int:
        """When the turn of that number begins, but for the chance."""
        return self.offset_ns + number * self.period_ns + self.delays_ns[number % len(self.delays_ns)]

    def _start_ns(self, number: int) -> int:
        return self.planned_ns(number) + _chance(self.seed, number) % (self.jitter_ns + 1)


def _chance(seed: int, number: int) -> int:
    """64 bits that look like chance (splitmix64, Steele et al. 2014)."""
    bits = (seed * 0xD1B5_4A32_D192_ED03 + (number + 1) * _MIX) & _MASK
    bits = (bits ^ bits >> 30) * 0xBF58_476D_1CE4_E5B9 & _MASK
    bits = (bits ^ bits >> 27) * 0x94D0_49BB_1331_11EB & _MASK
    return bits ^ bits >> 31


class Call(Enum):
    """Who fires a ranger."""

    ITSELF = "itself"
    ALL = "all"
    """It fires all of its kind on its bus, by a general call."""
    CALLED = "called"
    """Another one's general call fires it."""


@dataclass(frozen=True, slots=True)
class RangerRole:
    """A ranger's place in the robot."""

    name: str
    nearest: float
    """m, the blanking distance."""
    farthest: float
    """m, the reach that is asked for."""
    slot: Slot | None
    """When it may fire; None for those which fire by themselves."""
    speed_of_sound: float
    """m/s."""
    call: Call = Call.ITSELF


@dataclass(frozen=True, slots=True)
class Steering:
    """Where a wheel that is turned to steer stands straight ahead, and how far it can turn from there."""

    zero: float = 0.0
    """rad behind the gear: what its encoder tells when it is straight ahead."""
    most: float = pi
    """rad to either side: an angle beyond is an error."""


@dataclass(frozen=True, slots=True)
class WheelRole:
    """A wheel's place in the robot."""

    name: str
    gear: float = 1.0
    """Turns of the encoder for one turn of the wheel; negative if it counts backwards."""
    fastest: float = 100.0
    """rad/s of the wheel: a quicker change is a jump."""
    throttle: Throttle | None = None
    """What the wheel shall do; None: its motor is never touched."""
    listen_only: bool = False
    """Nothing at all may be sent on its bus."""
    steering: Steering | None = None
    """It is turned to steer, and its angle is told as it is; None: it rolls."""


@dataclass(frozen=True, slots=True)
class GyroRole:
    """A yaw gyro's place in the robot."""

    name: str
    listen_only: bool = False
    """Nothing at all may be sent on its bus."""
