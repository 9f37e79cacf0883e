"""What the robot asks of a device, whatever its make: its name, its limits, its turn to fire."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Slot:
    """A commanded ranger's turns: every `period_ns`, `offset_ns` after the clock's zero.

    Slots of several rangers keep their order and gaps across buses with no talk between them,
    because all are counted on the same clock.
    """

    period_ns: int
    offset_ns: int

    def next_ns(self, after_ns: int) -> int:
        """The first turn later than `after_ns`."""
        turns = (after_ns - self.offset_ns) // self.period_ns + 1
        return self.offset_ns + turns * self.period_ns


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


@dataclass(frozen=True, slots=True)
class WheelRole:
    """A wheel's place in the robot."""

    name: str
    gear: float = 1.0
    """Turns of the encoder for one turn of the wheel; negative if it counts backwards."""
    fastest: float = 100.0
    """rad/s of the wheel: a quicker change is a jump."""
