"""A prescribed drive along way points, as a closed-form function of time."""

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from math import atan2, copysign, cos, hypot, pi, radians, remainder, sin, sqrt
from typing import NamedTuple

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Limits:
    """How fast the robot may go."""

    speed: float = 0.4
    """m/s."""
    acceleration: float = 0.5
    """m/s^2."""
    turn_rate: float = radians(60.0)
    """rad/s."""
    turn_acceleration: float = radians(120.0)
    """rad/s^2."""


@dataclass(frozen=True, slots=True)
class Stroke:
    """One axis that goes a signed way from rest to rest: speeds up, cruises, slows down."""

    way: float
    """m or rad."""
    acceleration: float
    """Per s^2."""
    ramp: float
    """s: how long it speeds up, and slows down."""
    duration: float
    """s."""

    @classmethod
    def of(cls, way: float, top_speed: float, acceleration: float) -> "Stroke":
        """The quickest stroke within the limits."""
        ramp = min(top_speed / acceleration, sqrt(abs(way) / acceleration))
        cruise = abs(way) / (acceleration * ramp) - ramp if ramp else 0.0
        return cls(way, acceleration, ramp, 2.0 * ramp + cruise)

    def at(self, t_s: float) -> tuple[float, float]:
        """Way gone and speed at a time since its start, 0 to duration."""
        left = self.duration - t_s
        if t_s < self.ramp:
            gone, speed = 0.5 * self.acceleration * t_s**2, self.acceleration * t_s
        elif left < self.ramp:
            gone, speed = abs(self.way) - 0.5 * self.acceleration * left**2, self.acceleration * left
        else:
            speed = self.acceleration * self.ramp
            gone = speed * (t_s - 0.5 * self.ramp)
        return copysign(gone, self.way), copysign(speed, self.way)


@dataclass(frozen=True, slots=True)
class _Phase:
    """A stroke straight ahead or in place, and the state in which it begins."""

    stroke: Stroke
    turns: bool
    x: float
    y: float
    yaw: float
    distance: float


class _State(NamedTuple):
    """Where the robot is on its tour."""

    x: float
    y: float
    yaw: float
    distance: float
    speed: float
    turn_rate: float


@dataclass(frozen=True)
class Tour:
    """A closed round of straight lines and turns in place, driven again and again.

    It begins at rest on the first way point, heading for the second, and closes from the last to the first.
    Yaw and wheel angles are unwrapped: they are continuous, and go on counting from lap to lap. Time is
    since the start of the tour, s; before it the robot stands.
    """

    waypoints: Sequence[Point]
    """Map frame, m; neighbours differ."""
    spins: frozenset[int] = frozenset()
    """Indices of the way points on which it looks around: a full turn, counter-clockwise."""
    limits: Limits = Limits()
    wait: float = 0.0
    """s: how long the robot stands before it starts."""
    _phases: tuple[_Phase, ...] = field(init=False, repr=False)
    _starts: tuple[float, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        phases = tuple(self._plan())
        starts = accumulate((phase.stroke.duration for phase in phases), initial=0.0)
        object.__setattr__(self, "_phases", phases)
        object.__setattr__(self, "_starts", tuple(starts))

    @property
    def lap_time(self) -> float:
        """How long a lap takes, s."""
        return self._starts[-1]

    @property
    def lap_length(self) -> float:
        """How long a lap is, m."""
        last = self._phases[-1]
        return last.distance

    @property
    def lap_turn(self) -> float:
        """By how much a lap turns the robot, rad; full turns."""
        last, first = self._phases[-1], self._phases[0]
        return last.yaw + last.stroke.way - first.yaw

    def pose(self, t_s: float) -> tuple[float, float, float]:
        """x, y (m) and unwrapped yaw (rad) in the map frame."""
        state = self._state(t_s)
        return state.x, state.y, state.yaw

    def distance(self, t_s: float) -> float:
        """Way driven since the start, m; turns in place do not count."""
        return self._state(t_s).distance

    def twist(self, t_s: float) -> tuple[float, float]:
        """Forward speed, m/s, and turn rate, rad/s."""
        state = self._state(t_s)
        return state.speed, state.turn_rate

    def wheel_angles(self, t_s: float, wheel_radius: float, track: float) -> tuple[float, float]:
        """Left and right wheel of a differential drive, rad since the start; radius and track in m."""
        state = self._state(t_s)
        lead = 0.5 * track * (state.yaw - self._phases[0].yaw)
        return (state.distance - lead) / wheel_radius, (state.distance + lead) / wheel_radius

    def _state(self, t_s: float) -> _State:
        laps, in_lap = divmod(max(t_s - self.wait, 0.0), self.lap_time)
        index = bisect_right(self._starts, in_lap) - 1
        phase = self._phases[index]
        gone, speed = phase.stroke.at(in_lap - self._starts[index])
        yaw = phase.yaw + laps * self.lap_turn
        distance = phase.distance + laps * self.lap_length
        if phase.turns:
            return _State(phase.x, phase.y, yaw + gone, distance, 0.0, speed)
        x, y = phase.x + gone * cos(phase.yaw), phase.y + gone * sin(phase.yaw)
        return _State(x, y, yaw, distance + gone, speed, 0.0)

    def _plan(self) -> Iterator[_Phase]:
        """Drive each leg, look around if asked to, and turn towards the next; the last phase is a turn."""
        limits = self.limits
        headings = [atan2(dy, dx) for dx, dy in self._legs()]
        yaw, distance = headings[0], 0.0
        for index, (dx, dy) in enumerate(self._legs()):
            following = (index + 1) % len(self.waypoints)
            length = hypot(dx, dy)
            line = Stroke.of(length, limits.speed, limits.acceleration)
            yield _Phase(line, False, *self.waypoints[index], yaw, distance)
            distance += length
            turn = remainder(headings[following] - yaw, 2.0 * pi)
            if following in self.spins:
                turn += 2.0 * pi
            stroke = Stroke.of(turn, limits.turn_rate, limits.turn_acceleration)
            yield _Phase(stroke, True, *self.waypoints[following], yaw, distance)
            yaw += turn

    def _legs(self) -> list[Point]:
        ahead = [*self.waypoints[1:], self.waypoints[0]]
        return [(bx - ax, by - ay) for (ax, ay), (bx, by) in zip(self.waypoints, ahead, strict=True)]
