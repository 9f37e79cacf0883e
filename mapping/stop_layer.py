"""The stop layer: it knows no map. One near echo stops, whatever the maps make of it;
of what is farther away, two in a row that come so much nearer that a third would be near.

It takes raw readings, also those which are not verified: crosstalk may stop the robot until the ranger hears
better, and that is the price. No echo clears nothing here, and a ranger that looks ahead and tells nothing at
all stops, too.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import atan2, hypot

import numpy as np

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.footprint import Footprint
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger

FASTEST = 1.5
"""m/s: what comes nearer more quickly between two echoes is not one thing that approaches."""
_STEPS = 200


@dataclass(frozen=True, slots=True)
class StopZone:
    """Where an echo stops the robot."""

    distance: float
    """m from base_link, or from the footprint if there is one."""
    ahead: float
    """rad: the half angle of "ahead"."""
    hold_ns: int
    """For so long an echo stops, unless the ranger hears one from farther away; and for so long a ranger may
    tell nothing."""
    footprint: Footprint | None = None

    def away(self, x: float, y: float) -> float:
        """m from the robot to a point of base_link."""
        if self.footprint is None:
            return hypot(x, y)
        return float(self.footprint.distance(np.array([x]), np.array([y]))[0])

    def is_ahead(self, x: float, y: float) -> bool:
        """Whether a point is within the half angle, or before the footprint."""
        if abs(atan2(y, x)) <= self.ahead:
            return True
        outline = self.footprint
        return outline is not None and x > 0.0 and outline.y.min() <= y <= outline.y.max()

    def watched_by(self, ranger: Ranger) -> bool:
        """Whether a ranger's axis leads through the zone."""
        reach = np.linspace(ranger.nearest, ranger.farthest, _STEPS)
        points = (ranger.mount.compose(Pose(float(distance))) for distance in reach)
        return any(self.is_ahead(p.x, p.y) and self.away(p.x, p.y) <= self.distance for p in points)


class StopLayer:
    """Keeps, of each ranger that looks ahead, how far its last echo was and how long that stops the robot."""

    def __init__(self, rangers: Iterable[Ranger], zone: StopZone) -> None:
        self._zone = zone
        self._rangers = {ranger.name: ranger for ranger in rangers}
        self._latest: dict[str, tuple[int, float]] = {}
        self._stops: dict[str, int] = {}
        self._told: dict[str, int] = {}
        self.needed = tuple(name for name, ranger in self._rangers.items() if zone.watched_by(ranger))
        """Those which look into the zone."""

    def take(self, reading: RangeReading) -> None:
        """A raw reading; only echoes, and what is too close, say something."""
        ranger = self._rangers.get(reading.sensor)
        if ranger is None or reading.listened or reading.outcome is Outcome.INVALID:
            return
        self._told[reading.sensor] = max(self._told.get(reading.sensor, 0), reading.stamp_ns)
        if reading.outcome is Outcome.TOO_CLOSE:
            self._judge(reading, ranger, ranger.nearest, touches=True)
        elif reading.outcome is Outcome.ECHO:
            self._judge(reading, ranger, reading.distance)

    def must_stop(self, now_ns: int) -> bool:
        """Whether a ranger has heard something in the zone, and nothing beyond since then."""
        return any(now_ns - stamp_ns <= self._zone.hold_ns for stamp_ns in self._stops.values())

    def silent(self, now_ns: int) -> tuple[str, ...]:
        """The needed rangers that have told something, but not lately."""
        oldest_ns = now_ns - self._zone.hold_ns
        return tuple(name for name in self.needed if name in self._told and self._told[name] < oldest_ns)

    def is_old(self, stamp_ns: int, now_ns: int) -> bool:
        """Whether what was told then is no news any more."""
        return now_ns - stamp_ns > self._zone.hold_ns

    def unheard(self) -> tuple[str, ...]:
        """The needed rangers that have never told anything."""
        return tuple(name for name in self.needed if name not in self._told)

    def _judge(self, reading: RangeReading, ranger: Ranger, distance: float, touches: bool = False) -> None:
        """See whether something at that distance (m) stops; it does if it may touch the ranger."""
        obstacle = ranger.mount.compose(Pose(distance))
        if not self._zone.is_ahead(obstacle.x, obstacle.y):
            return
        away = self._zone.away(obstacle.x, obstacle.y)
        if touches or min(away, self._next(reading, away)) <= self._zone.distance:
            self._stops[reading.sensor] = reading.stamp_ns
        else:
            self._stops.pop(reading.sensor, None)
        self._latest[reading.sensor] = reading.stamp_ns, away

    def _next(self, reading: RangeReading, away: float) -> float:
        """m: where the next echo will be from, by the last two in a row."""
        stamp_ns, before = self._latest.get(reading.sensor, (0, away))
        approach, gap_ns = before - away, reading.stamp_ns - stamp_ns
        believable = gap_ns <= self._zone.hold_ns and approach <= FASTEST * 1e-9 * gap_ns
        return away - approach if believable else away
