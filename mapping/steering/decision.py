"""What a way of steering says: where to go, how fast, why, and what it saw."""

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from echogrid.mapping.steering.goal import Goal
from echogrid.mapping.steering.obstacles import View
from echogrid.mapping.steering.sectors import Floats, Mask


class Why(Enum):
    """The reason of a heading, or of none."""

    TARGET = "straight to the goal"
    AROUND = "around an obstacle"
    BLOCKED = "every way is blocked"
    TOUCHING = "something is within the robot"
    BALANCED = "the forces cancel each other"


@dataclass(frozen=True, slots=True)
class Polar:
    """What a decision was taken from, by sectors, for pictures and for the way out of a corner."""

    density: Floats
    """(n,) how much stands in that direction; the unit is the method's own."""
    low: float
    """Below this a sector is free."""
    high: float
    """Above this a sector is blocked; between both it stays as it was."""
    blocked: Mask
    """(n,) by its density, or because it is not known."""
    masked: Mask
    """(n,) out of reach, as a turning circle meets an obstacle."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A direction that was weighed."""

    sector: float
    cost: float


@dataclass(frozen=True, slots=True)
class Decision:
    """Where to go next."""

    heading: float | None
    """rad, in the grid's frame; None if there is no way."""
    factor: float
    """0...1: the part of the full speed that the method grants."""
    why: Why
    goal: Goal
    polar: Polar
    candidates: tuple[Candidate, ...] = ()
    """Those that were weighed, the chosen one first."""


class Steering(Protocol):
    """A way of steering. It may remember what it decided last."""

    def steer(self, view: View, speed: float, goal: Goal, /) -> Decision:
        """The heading to take at that speed (m/s)."""
        ...

    def forget(self) -> None:
        """Begin anew, as after a pause or a new goal."""
        ...
