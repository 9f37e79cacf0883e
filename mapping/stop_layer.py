"""The stop layer: it knows no map. One near echo stops, whatever the maps make of it;
of what is farther away, two in a row that come so much nearer that a third would be near.

It takes raw readings, also those which are not verified: crosstalk may stop the robot until the ranger hears
better, and that is the price. Silence clears nothing here.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import atan2, hypot

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger

FASTEST = 1.5
"""m/s: what comes nearer more quickly between two echoes is not one thing that approaches."""


@dataclass(frozen=True, slots=True)
class StopZone:
    """Where an echo stops the robot."""

    distance: float
    """m from base_link."""
    ahead: float
    """rad: the half angle of "ahead"."""
    hold_ns: int
    """For so long an echo stops, unless the ranger hears one from farther away."""


class StopLayer:
    """Keeps, of each ranger that looks ahead, how far its last echo was and how long that stops the robot."""

    def __init__(self, rangers: Iterable[Ranger], zone: StopZone) -> None:
        self._zone = zone
        self._rangers = {ranger.name: ranger for ranger in rangers}
        self._latest: dict[str, tuple[int, float]] = {}
        self._stops: dict[str, int] = {}

    def take(self, reading: RangeReading) -> None:
        """A raw reading; only echoes, and what is too close, say something."""
        ranger = self._rangers.get(reading.sensor)
        if ranger is None or reading.listened:
            return
        if reading.outcome is Outcome.TOO_CLOSE:
            self._judge(reading, ranger, ranger.nearest, touches=True)
        elif reading.outcome is Outcome.ECHO:
            self._judge(reading, ranger, reading.distance)

    def must_stop(self, now_ns: int) -> bool:
        """Whether a ranger has heard something in the zone, and nothing beyond since then."""
        return any(now_ns - stamp_ns <= self._zone.hold_ns for stamp_ns in self._stops.values())

    def _judge(self, reading: RangeReading, ranger: Ranger, distance: float, touches: bool = False) -> None:
        """See whether something at that distance (m) stops; it does if it may touch the ranger."""
        obstacle = ranger.mount.compose(Pose(distance))
        if abs(atan2(obstacle.y, obstacle.x)) > self._zone.ahead:
            return
        away = hypot(obstacle.x, obstacle.y)
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
