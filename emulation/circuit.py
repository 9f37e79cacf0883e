"""A prescribed drive for a robot that can't turn in place: straight lines, and arcs around the corners."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import atan2, copysign, cos, hypot, pi, remainder, sin, tan

from echogrid.emulation.motion import Limits, Point
from echogrid.emulation.round import LINE, Bend, Phase, Round
from echogrid.emulation.stroke import Stroke


@dataclass(frozen=True, slots=True)
class _Leg:
    """From one corner to the next, as far as it is straight."""

    x: float
    y: float
    heading: float
    length: float
    turn: float
    """rad, at its end."""


@dataclass(frozen=True)
class Circuit(Round):
    """A closed round through way points whose corners are arcs of one radius, driven again and again.

    It stops before and after each arc, to turn its steering. It begins at rest where the first corner's arc
    ends, heading for the second way point; the last arc leads back there.
    """

    waypoints: Sequence[Point]
    """Map frame, m; neighbours differ. Raises ValueError if they are too close for the arcs."""
    radius: float
    """m, of base_link's way around a corner."""
    limits: Limits = field(default_factory=Limits)
    wait: float = 0.0
    """s: how long the robot stands before it starts."""
    pause: float = 1.0
    """s: how long it stands before each line and each arc."""

    def _plan(self) -> Iterator[Phase]:
        limits, distance = self.limits, 0.0
        speed = min(limits.speed, limits.turn_rate * self.radius)
        for leg in self._legs():
            line = Stroke.of(leg.length, limits.speed, limits.acceleration)
            yield Phase(line, LINE, leg.x, leg.y, leg.heading, distance)
            distance += leg.length
            if leg.turn:
                arc = Stroke.of(self.radius * abs(leg.turn), speed, limits.acceleration)
                end_x = leg.x + leg.length * cos(leg.heading)
                end_y = leg.y + leg.length * sin(leg.heading)
                bend = Bend(1.0, copysign(1.0 / self.radius, leg.turn))
                yield Phase(arc, bend, end_x, end_y, leg.heading, distance)
                distance += arc.way

    def _legs(self) -> Iterator[_Leg]:
        """The headings are unwrapped."""
        points = [*self.waypoints, *self.waypoints[:2]]
        sides = [(bx - ax, by - ay) for (ax, ay), (bx, by) in pairwise(points)]
        headings = [atan2(dy, dx) for dx, dy in sides]
        turns = [remainder(after - before, 2.0 * pi) for before, after in pairwise(headings)]
        cuts = [self.radius * tan(abs(turn) / 2.0) for turn in turns]
        heading = headings[0]
        for index, turn in enumerate(turns):
            start, length = cuts[index - 1], hypot(*sides[index]) - cuts[index - 1] - cuts[index]
            if length < 0.0:
                raise ValueError(f"way points {index} and {index + 1}: too close for arcs of {self.radius} m")
            x, y = self.waypoints[index]
            yield _Leg(x + start * cos(heading), y + start * sin(heading), heading, length, turn)
            heading += turn
