"""A round of strokes from rest to rest, driven again and again, as a closed-form function of time."""

from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate
from math import atan2, copysign, cos, hypot, sin
from typing import NamedTuple

from echogrid.emulation.stroke import Stroke


class Bend(NamedTuple):
    """Where a stroke leads: what the robot does for each unit of it."""

    way: float
    """m ahead."""
    turn: float
    """rad, counter-clockwise."""


LINE, TURN = Bend(1.0, 0.0), Bend(0.0, 1.0)
"""Straight ahead by m, and on the spot by rad."""


class _State(NamedTuple):
    """Where the robot is on a lap."""

    x: float
    y: float
    yaw: float
    distance: float
    speed: float
    turn_rate: float


@dataclass(frozen=True, slots=True)
class Phase:
    """A stroke along a line or an arc, or on the spot, and the state in which it begins."""

    stroke: Stroke
    bend: Bend
    x: float
    y: float
    yaw: float
    distance: float

    def at(self, t_s: float) -> _State:
        """The state at a time since its start, 0 to its duration."""
        gone, speed = self.stroke.at(t_s)
        way, turn = gone * self.bend.way, gone * self.bend.turn
        chord = way * (sin(turn / 2.0) / (turn / 2.0) if turn else 1.0)
        heading = self.yaw + turn / 2.0
        return _State(
            self.x + chord * cos(heading),
            self.y + chord * sin(heading),
            self.yaw + turn,
            self.distance + way,
            speed * self.bend.way,
            speed * self.bend.turn,
        )

    def steering(self, wheelbase: float) -> float:
        """rad: how a wheel stands that is so far (m) before base_link and rolls forward; 0 if none moves."""
        if not self.stroke.way:
            return 0.0
        direction = copysign(1.0, self.stroke.way)
        return atan2(direction * self.bend.turn * wheelbase, direction * self.bend.way)

    def rolled(self, t_s: float, wheelbase: float) -> float:
        """m: how far that wheel has rolled."""
        return abs(self.stroke.at(t_s)[0]) * hypot(self.bend.way, self.bend.turn * wheelbase)


class Round(ABC):
    """Begins and ends at rest, at the same place. Yaw and ways are unwrapped: they are continuous, and go on
    counting from lap to lap. Time is since its start, s; before it the robot stands."""

    wait: float
    """s: how long the robot stands before it starts."""
    pause: float
    """s: how long it stands before each phase."""
    _phases: tuple[Phase, ...]
    _starts: tuple[float, ...]
    _lap: tuple[float, float]

    def __post_init__(self) -> None:
        phases = tuple(self._plan())
        starts = accumulate((self.pause + phase.stroke.duration for phase in phases), initial=0.0)
        object.__setattr__(self, "_phases", phases)
        object.__setattr__(self, "_starts", tuple(starts))
        end = phases[-1].at(phases[-1].stroke.duration)
        object.__setattr__(self, "_lap", (end.distance, end.yaw - phases[0].yaw))

    @abstractmethod
    def _plan(self) -> Iterator[Phase]:
        """All phases, in order; each begins where the one before it ends."""

    @property
    def lap_time(self) -> float:
        """How long a lap takes, s."""
        return self._starts[-1]

    @property
    def lap_length(self) -> float:
        """How long a lap is, m."""
        return self._lap[0]

    @property
    def lap_turn(self) -> float:
        """By how much a lap turns the robot, rad; full turns."""
        return self._lap[1]

    def pose(self, t_s: float) -> tuple[float, float, float]:
        """x, y (m) and unwrapped yaw (rad) in the map frame."""
        laps, state = self._state(t_s)
        return state.x, state.y, state.yaw + laps * self.lap_turn

    def distance(self, t_s: float) -> float:
        """Way driven since the start, m; turns in place do not count."""
        laps, state = self._state(t_s)
        return state.distance + laps * self.lap_length

    def twist(self, t_s: float) -> tuple[float, float]:
        """Forward speed, m/s, and turn rate, rad/s."""
        _, state = self._state(t_s)
        return state.speed, state.turn_rate

    def wheel_angles(self, t_s: float, wheel_radius: float, track: float) -> tuple[float, float]:
        """Left and right wheel of a differential drive, rad since the start; radius and track in m."""
        distance, lead = self.distance(t_s), 0.5 * track * (self.pose(t_s)[2] - self._phases[0].yaw)
        return (distance - lead) / wheel_radius, (distance + lead) / wheel_radius

    def steering(self, t_s: float, wheelbase: float) -> float:
        """rad: how a wheel stands that is so far (m) before base_link and rolls forward.

        It is turned evenly while the robot pauses; without a pause, at once.
        """
        _, index, since_s = self._place(t_s)
        after = self._phases[index].steering(wheelbase)
        if since_s >= self.pause:
            return after
        before = self._phases[index - 1].steering(wheelbase)
        return before + (after - before) * since_s / self.pause

    def rolled(self, t_s: float, wheelbase: float) -> float:
        """m: how far that wheel has rolled since the start."""
        laps, index, since_s = self._place(t_s)
        ways = [phase.rolled(phase.stroke.duration, wheelbase) for phase in self._phases]
        here = self._phases[index].rolled(max(since_s - self.pause, 0.0), wheelbase)
        return laps * sum(ways) + sum(ways[:index]) + here

    def _place(self, t_s: float) -> tuple[float, int, float]:
        """Full laps so far, the number of the phase, and the time since the pause before that began."""
        laps, in_lap = divmod(max(t_s - self.wait, 0.0), self.lap_time)
        index = bisect_right(self._starts, in_lap) - 1
        return laps, index, in_lap - self._starts[index]

    def _state(self, t_s: float) -> tuple[float, _State]:
        """Full laps so far, and the state on the one under way."""
        laps, index, since_s = self._place(t_s)
        return laps, self._phases[index].at(max(since_s - self.pause, 0.0))
