"""Somebody who walks by: a soft cylinder on a prescribed way, as a closed-form function of time."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from math import hypot

from echogrid.emulation.vista import Point, Post

WALKING_SPEED = 0.8
"""m/s."""


@dataclass(frozen=True)
class Walker:
    """Walks round and round along straight lines through way points, at a constant speed."""

    waypoints: Sequence[Point]
    """Map frame, m; neighbours differ, and the last leads to the first."""
    start: float = 0.0
    """m of the way that are behind at time 0."""
    speed: float = WALKING_SPEED
    """m/s."""
    radius: float = 0.22
    """m: 0.2 to 0.25."""
    softness: float = 12.0
    """dB that clothes take from the echo: 10 to 15."""
    _legs: tuple[tuple[Point, Point], ...] = field(init=False, repr=False)
    _reached: tuple[float, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        legs = tuple(zip(self.waypoints, [*self.waypoints[1:], self.waypoints[0]], strict=True))
        ways = (hypot(bx - ax, by - ay) for (ax, ay), (bx, by) in legs)
        object.__setattr__(self, "_legs", legs)
        object.__setattr__(self, "_reached", tuple(accumulate(ways, initial=0.0)))

    @property
    def lap_length(self) -> float:
        """How long a lap is, m."""
        return self._reached[-1]

    def at(self, time_s: float) -> Post:
        """Where they are at a time."""
        gone = (self.start + self.speed * time_s) % self.lap_length
        index = min(bisect_right(self._reached, gone), len(self.waypoints)) - 1
        before, after = self._reached[index : index + 2]
        (ax, ay), (bx, by) = self._legs[index]
        share = (gone - before) / (after - before)
        return Post(ax + share * (bx - ax), ay + share * (by - ay), self.radius, self.softness)
