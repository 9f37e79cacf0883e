"""What is around the robot now: the local grid, what is read from it, and the stop layer beneath."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import sqrt

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.approach import Approach
from echogrid.mapping.company import PAUSE_NS, Company
from echogrid.mapping.free_path import STANDING, FreePath, PathEnd, PathSensor
from echogrid.mapping.latency import Latency
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.planning.tracking import PlanTracker
from echogrid.mapping.pose import Pose
from echogrid.mapping.stop_layer import StopLayer
from echogrid.mapping.twist import Twist
from echogrid.mapping.unknown import Unknown
from echogrid.mapping.verification import Believer, Verifier, heard_at
from echogrid.mapping.virtual_sensor import Ahead, ObstacleView, StopReason, VirtualSensor

_WORST_FIRST = tuple(StopReason)
_ENDS = {
    PathEnd.OBSTACLE: StopReason.NEAR,
    PathEnd.UNKNOWN: StopReason.UNKNOWN,
    PathEnd.HORIZON: StopReason.UNKNOWN,
    PathEnd.STALE: StopReason.STALE,
}


@dataclass(frozen=True, slots=True)
class Readers:
    """What looks at the local grid."""

    sectors: VirtualSensor
    path: PathSensor
    unknown: Unknown
    slow: float
    """m/s at most where something ahead is unknown, with Unknown.SLOW."""
    reaction_ns: int
    """From a view to the wheels that heed it."""
    pause_ns: int = PAUSE_NS
    """For so long a thing that stands may be silent."""


class Lookout:
    """The stop layer hears every reading; the local grid sees those which are verified."""

    def __init__(
        self,
        local: LocalGrid,
        readers: Readers,
        stop: StopLayer,
        verifier: Verifier | Believer,
        tracker: PlanTracker | None = None,
    ) -> None:
        """With a `tracker` the walls of its plan are known."""
        self.local = local
        """To be read, not written."""
        self._readers = readers
        self._stop = stop
        self._verifier = verifier
        self._latency = Latency()
        self._approach = Approach(readers.path.reach)
        self._company = Company(readers.path.reach, readers.pause_ns)
        self._tracker = tracker

    def hear(self, readings: Iterable[RangeReading], now_ns: int) -> None:
        """Raw readings, as they came in."""
        taken = tuple(readings)
        self._latency.take(taken, now_ns)
        for reading in taken:
            self._stop.take(reading)

    def see(self, placed: Iterable[PlacedPing], robot: Pose, now_ns: int) -> None:
        """Fuse newly placed pings into the grid around the robot (its pose in the odom frame)."""
        self.local.centre(robot)
        self.local.fade(now_ns)
        if self._tracker is not None:
            self._tracker.move(robot)
        for ping in placed:
            for verified in self._verifier.take(ping).verified:
                self._take(verified)
        self.local.vacate(self._readers.path.beneath(self.local, robot))
        if self._tracker is not None:
            half = 0.5 * self.local.geometry.rows * self.local.geometry.resolution
            self.local.build(self._tracker.walls(robot, sqrt(2.0) * half), now_ns)

    def view(self, robot: Pose, now_ns: int, twist: Twist) -> ObstacleView:
        """The obstacles around the robot, and the way along a twist.

        What is ahead stops it if the twist leads ahead, or is none. While no ranger at all tells anything
        nothing may be driven.
        """
        path, reasons = self._judged(robot, now_ns, twist)
        heard_ns = self._latency.newest_ns
        return replace(
            self._readers.sectors.view(self.local, robot, now_ns),
            reason=next((reason for reason in _WORST_FIRST if reason in reasons), None),
            path=path,
            silent=(*self._stop.silent(now_ns), *self._stop.unheard()),
            age_ns=max(now_ns - heard_ns, 0) if heard_ns else None,
            latency_ns=self.latency_ns,
        )

    def allowed(self, robot: Pose, now_ns: int, wish: Twist) -> Twist:
        """The safe part of a wish: as far as the way along it allows, at the same curve; if that must not be
        driven, what it says of turning, as far as that is free."""
        if wish.stands:
            return STANDING
        path, reasons = self._judged(robot, now_ns, wish)
        if not reasons:
            return path.allowed
        turn = Twist(0.0, wish.turn_rate)
        if wish.speed == 0.0 or turn.stands:
            return STANDING
        path, reasons = self._judged(robot, now_ns, turn)
        return STANDING if reasons else path.allowed

    def path(self, robot: Pose, now_ns: int, twist: Twist) -> FreePath:
        """The way along any twist."""
        return self._readers.path.look(self.local, robot, now_ns, twist, self.latency_ns * 1e-9)

    @property
    def latency_ns(self) -> int:
        """From a sound's echo to wheels that heed it: as measured, up to the tick, and what follows."""
        return self._latency.worst_ns + self._readers.reaction_ns

    def _judged(self, robot: Pose, now_ns: int, twist: Twist) -> tuple[FreePath, set[StopReason]]:
        """The way along a twist, and all that stops whoever takes it."""
        path = self.path(robot, now_ns, twist)
        reasons = {_ENDS[path.end]} if path.limit == 0.0 else set()
        if twist.speed > 0.0 or twist.stands:
            ahead = self._readers.sectors.ahead(self.local, robot, now_ns)
            reasons |= self._ahead(ahead, now_ns)
            path = self._slowed(ahead, path)
        if twist.speed != 0.0 or twist.stands:
            path = path.limited(self._met(robot, now_ns))
            reasons |= {StopReason.NEAR} if path.limit == 0.0 and not reasons else set()
        heard_ns = self._latency.newest_ns
        if not heard_ns:
            reasons.add(StopReason.UNKNOWN)
        elif self._stop.is_old(heard_ns, now_ns):
            reasons.add(StopReason.SILENT)
        return path, reasons

    def _ahead(self, ahead: Ahead, now_ns: int) -> set[StopReason]:
        """What stops whoever drives ahead."""
        reasons = {ahead.reason} if ahead.reason else set()
        if self._stop.must_stop(now_ns):
            reasons.add(StopReason.NEAR)
        if self._readers.unknown is not Unknown.SLOW:
            reasons |= {StopReason.SILENT} if self._stop.silent(now_ns) else set()
            reasons |= {StopReason.UNKNOWN} if self._stop.unheard() else set()
        return reasons

    def _met(self, robot: Pose, now_ns: int) -> float:
        """m/s from which the robot stands before who comes, or may come, is there."""
        reaction_s, deceleration = self._readers.reaction_ns * 1e-9, self._readers.path.deceleration
        return min(
            self._approach.limit(now_ns, reaction_s, deceleration),
            self._company.limit(now_ns, robot, reaction_s, deceleration),
        )

    def _slowed(self, ahead: Ahead, path: FreePath) -> FreePath:
        """The way ahead, where something beside it is unknown or stale."""
        if self._readers.unknown is not Unknown.SLOW or not ahead.doubtful:
            return path
        return path.limited(self._readers.slow)

    def _take(self, ping: PlacedPing) -> None:
        """For avoidance, what is too close is an obstacle at the blanking distance."""
        known = self._tracker is not None and self._tracker.explains(ping)
        if not known:
            moves = self._approach.take(ping)
            self._company.take(ping, moves, strange=self._tracker is not None)
        if ping.reading.outcome is not Outcome.INVALID:
            self.local.fuse(ping.transducer, ping.ranger, heard_at(ping), ping.reading.stamp_ns, known)
