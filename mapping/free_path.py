"""How far, and so how fast, the robot may go on with a twist: its footprint swept through the local grid."""

from dataclasses import dataclass, field, replace
from enum import Enum
from math import ceil, cos, inf, pi, sin, sqrt, tau

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.bayes import MILLI
from echogrid.mapping.braking import Brakes, speed_limit
from echogrid.mapping.footprint import Floats, Footprint
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.swept_path import fastest, sweeps, touches
from echogrid.mapping.twist import Twist
from echogrid.mapping.unknown import Unknown

_MOST_COURSES = 64
AHEAD = Twist(1.0)
STANDING = Twist()
MODEST = Twist(0.5, pi / 2.0)


class PathEnd(Enum):
    """What ends the free way."""

    OBSTACLE = "obstacle"
    UNKNOWN = "unknown"
    STALE = "stale"
    HORIZON = "horizon"
    """Nothing does, as far as one looks."""


@dataclass(frozen=True, slots=True)
class FreePath:
    """The way along a twist.

    Ways and speeds are those of the point of the footprint that moves fastest: straight ahead they are
    base_link's; in a turn on the spot they are those of the farthest corner.
    """

    twist: Twist = STANDING
    """What was asked about; a robot that stands is asked about its way straight ahead."""
    distance: float = 0.0
    """m."""
    seconds: float = inf
    """To the collision, at that twist; inf if there is none as far as one looks, or the robot stands."""
    end: PathEnd = PathEnd.UNKNOWN
    limit: float = 0.0
    """m/s from which it still stops in time."""
    speed: float = 0.0
    """m/s at that twist."""

    @property
    def scale(self) -> float:
        """0...1: what of the twist is within the limit."""
        return min(1.0, self.limit / self.speed) if self.speed else 0.0

    @property
    def allowed(self) -> Twist:
        """The same curve, no faster than the limit."""
        return self.twist.times(self.scale)

    def limited(self, limit: float) -> "FreePath":
        """The same with a limit that is no higher."""
        return replace(self, limit=min(self.limit, limit))


UNSEEN = FreePath()
"""Nothing is known of the way."""


@dataclass(frozen=True, slots=True)
class PathSight:
    """How the way is looked at."""

    brakes: Brakes = field(default_factory=Brakes)
    unknown: Unknown = Unknown.BLOCKED
    slow: float = 0.1
    """m/s at most where the way is unknown, with Unknown.SLOW."""
    skin: float = 0.3
    """m around the footprint in which cells need not have been seen: the cones only begin there."""
    known: float = 0.25
    """The part of the cells across the way that must have been seen as free, and lately."""
    most: Twist = MODEST
    """m/s and rad/s: no limit is higher."""
    horizon: float = 2.0
    """m from base_link."""
    occupied: float = 0.85
    """nats from which a cell is an obstacle."""
    stale_ns: int = 1_000_000_000


@dataclass(frozen=True, slots=True)
class _Course:
    """Places (base_link) that a twist sweeps and that must be known, by their distance along the way."""

    x: Floats
    y: Floats
    start: float
    """m of the way to the first of them."""
    step: NDArray[np.intp]
    """(n,) How many cells' lengths later each is swept."""
    total: NDArray[np.intp]
    """(steps,)"""


class PathSensor:
    """Reads a local grid of a fixed size, whose window keeps the robot in its middle cell.

    An obstacle's cell counts as the disc around it. What must be known is asked at points of a lattice that
    is fixed to the robot, one for each cell.
    """

    def __init__(self, footprint: Footprint, sight: PathSight, resolution: float, cells: int) -> None:
        self._footprint = footprint
        self._sight = sight
        self._resolution = resolution
        self._horizon = min(sight.horizon, (cells // 2 - 1) * resolution)
        self._radius = resolution * sqrt(0.5)
        offsets = (np.arange(cells, dtype=np.float64) - cells // 2) * resolution
        near = np.hypot(offsets[np.newaxis, :], offsets[:, np.newaxis]) <= self._horizon
        self._rows, self._cols = np.nonzero(near)
        self._flat = self._rows * cells + self._cols
        self._occupied = ceil(sight.occupied * MILLI)
        """Milli-nats."""
        self._courses: dict[Twist, _Course] = {}
        x, y = offsets[self._cols], offsets[self._rows]
        self._near = np.flatnonzero(np.hypot(x, y) <= footprint.reach + resolution)
        """Which of them may lie beneath the robot."""
        asked = footprint.distance(x, y) > sight.skin
        self._asked = x[asked], y[asked]

    @property
    def reach(self) -> float:
        """m: nothing of the footprint is farther from base_link."""
        return self._footprint.reach

    @property
    def deceleration(self) -> float:
        """m/s^2 with which the robot stops."""
        return self._sight.brakes.deceleration

    def beneath(self, local: LocalGrid, robot: Pose) -> NDArray[np.intp]:
        """(n,) the cells, row * columns + column, whose middles lie within the footprint."""
        geometry = local.geometry
        dx = geometry.x + (self._cols[self._near] + 0.5) * geometry.resolution - robot.x
        dy = geometry.y + (self._rows[self._near] + 0.5) * geometry.resolution - robot.y
        c, s = cos(robot.yaw), sin(robot.yaw)
        cells: NDArray[np.intp] = self._flat[self._near]
        return cells[self._footprint.contains(c * dx + s * dy, c * dy - s * dx)]

    def look(self, local: LocalGrid, robot: Pose, now_ns: int, twist: Twist, latency_s: float) -> FreePath:
        """The way along a twist, from the robot's pose in the odom frame."""
        sight = self._sight
        course = AHEAD if twist.stands else twist
        speed = fastest(self._footprint, course)
        course = course.times(1.0 / speed)  # now a second is a metre of the fastest point's way
        clear, end = self._clear(local, robot, course)
        known, why = self._known(local, robot, now_ns, course)
        cap = self._cap(course)
        limit = min(cap, speed_limit(clear, latency_s, sight.brakes))
        if known < clear and sight.unknown is not Unknown.CLEAR:
            certain = min(cap, speed_limit(known, latency_s, sight.brakes))
            limit = certain if sight.unknown is Unknown.BLOCKED else min(limit, max(certain, sight.slow))
            if sight.unknown is Unknown.BLOCKED:
                clear, end = known, why
        if twist.stands:
            return FreePath(twist, clear, inf, end, limit)
        seconds = inf if end is PathEnd.HORIZON else clear / speed
        return FreePath(twist, clear, seconds, end, limit, speed)

    def _clear(self, local: LocalGrid, robot: Pose, course: Twist) -> tuple[float, PathEnd]:
        """m to the first obstacle, or as far as one looks."""
        geometry, horizon = local.geometry, self._looked_at(course)
        if course.speed == 0.0 and self._footprint.is_round:
            return horizon, PathEnd.HORIZON
        (hits,) = (local.grid.log_odds.take(self._flat) >= self._occupied).nonzero()
        dx = geometry.x + (self._cols.take(hits) + 0.5) * geometry.resolution - robot.x
        dy = geometry.y + (self._rows.take(hits) + 0.5) * geometry.resolution - robot.y
        c, s = cos(robot.yaw), sin(robot.yaw)
        ways = touches(self._footprint, course, c * dx + s * dy, c * dy - s * dx, self._radius, horizon)
        nearest = float(ways.min(initial=inf))
        return (nearest, PathEnd.OBSTACLE) if nearest < horizon else (horizon, PathEnd.HORIZON)

    def _looked_at(self, course: Twist) -> float:
        """m in which the footprint surely stays within the horizon, or comes round."""
        room = max(self._horizon - self._footprint.reach - self._radius, 0.0)
        straight = room / abs(course.speed) if course.speed else inf
        around = tau / abs(course.turn_rate) if course.turn_rate else inf
        return min(straight, around) if room > 0.0 else 0.0

    def _known(self, local: LocalGrid, robot: Pose, now_ns: int, course: Twist) -> tuple[float, PathEnd]:
        """m to where too little of what is swept was seen as free lately, less a cell; and if it ever was.

        inf if that is nowhere; 0 if it is where something must be known for the first time.
        """
        swept = self._courses.get(course) or self._swept(course)
        geometry = local.geometry
        c, s = cos(robot.yaw), sin(robot.yaw)
        cols = np.floor((robot.x + c * swept.x - s * swept.y - geometry.x) / geometry.resolution)
        rows = np.floor((robot.y + s * swept.x + c * swept.y - geometry.y) / geometry.resolution)
        places = rows.astype(np.intp) * geometry.cols + cols.astype(np.intp)
        free = local.grid.log_odds.take(places) < self._occupied
        seen_ns = local.seen_ns.take(places)
        enough = self._sight.known * swept.total
        lately = np.bincount(swept.step, free & (seen_ns > now_ns - self._sight.stale_ns), len(enough))
        lacking = np.flatnonzero(lately < enough)
        if not len(lacking):
            return inf, PathEnd.HORIZON
        first = int(lacking[0])
        ever = np.bincount(swept.step, free & (seen_ns > 0), len(enough))
        why = PathEnd.STALE if ever[first] >= enough[first] else PathEnd.UNKNOWN
        return swept.start + (first - 1) * self._resolution if first else 0.0, why

    def _swept(self, course: Twist) -> _Course:
        x, y = self._asked
        horizon = self._looked_at(course)
        ways = sweeps(self._footprint, course, x, y, horizon)
        (swept,) = (ways < horizon).nonzero()
        start = float(ways.min(initial=inf))
        step = np.rint((ways.take(swept) - start) / self._resolution).astype(np.intp)
        if len(self._courses) >= _MOST_COURSES:
            self._courses.clear()
        made = self._courses[course] = _Course(x.take(swept), y.take(swept), start, step, np.bincount(step))
        return made

    def _cap(self, course: Twist) -> float:
        """m/s of the fastest point at the highest speed and turn rate."""
        speeds = (
            abs(most / part)
            for most, part in (
                (self._sight.most.speed, course.speed),
                (self._sight.most.turn_rate, course.turn_rate),
            )
            if part
        )
        return min(speeds)
