"""A prescribed drive along way points, as a closed-form function of time."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan2, hypot, pi, radians, remainder

from echogrid.emulation.round import LINE, TURN, Phase, Round
from echogrid.emulation.stroke import Stroke

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


@dataclass(frozen=True)
class Tour(Round):
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
    pause: float = 0.0
    """s: how long it stands before each line and each turn."""

    def _plan(self) -> Iterator[Phase]:
        """Drive each leg, look around if asked to, and turn towards the next; the last phase is a turn."""
        limits = self.limits
        headings = [atan2(dy, dx) for dx, dy in self._legs()]
        yaw, distance = headings[0], 0.0
        for index, (dx, dy) in enumerate(self._legs()):
            following = (index + 1) % len(self.waypoints)
            length = hypot(dx, dy)
            line = Stroke.of(length, limits.speed, limits.acceleration)
            yield Phase(line, LINE, *self.waypoints[index], yaw, distance)
            distance += length
            turn = remainder(headings[following] - yaw, 2.0 * pi)
            if following in self.spins:
                turn += 2.0 * pi
            stroke = Stroke.of(turn, limits.turn_rate, limits.turn_acceleration)
            yield Phase(stroke, TURN, *self.waypoints[following], yaw, distance)
            yaw += turn

    def _legs(self) -> list[Point]:
        ahead = [*self.waypoints[1:], self.waypoints[0]]
        return [(bx - ax, by - ay) for (ax, ay), (bx, by) in zip(self.waypoints, ahead, strict=True)]
