"""Towards a point, past what stands in the way; along a way by a floor plan if there is one."""

from collections.abc import Mapping
from math import hypot, inf
from typing import Any

from echogrid.mapping.planning.tracking import PlanTracker
from echogrid.mapping.pose import Pose
from echogrid.mapping.steering.goal import towards
from echogrid.mapping.steering.navigator import Moment, Navigator
from echogrid.mapping.steering.recovery import Stage
from echogrid.mapping.twist import Twist
from echogrid.runtime.modes.guide import Guide
from echogrid.runtime.modes.mode import End, Situation
from echogrid.runtime.modes.progress import Progress

ARRIVED = 0.15
"""m: so near it is there."""
_STUCK_M = 0.3
_STUCK_NS = 20_000_000_000
_DETOUR_NS = 90_000_000_000
"""So long it may take to come nearer to the goal than it ever was ..."""
_NS_PER_M = 5_000_000_000
"""... and so much longer for each metre of a way around, if it goes by a floor plan."""


class Goto:
    """Ends at the goal (m, odom frame; with a guide, its plan's), or where it gets on no more."""

    name = "goto"
    patient = False

    def __init__(self, navigator: Navigator, x: float, y: float, guide: Guide | None = None) -> None:
        self.end: End | None = None
        self.tracker: PlanTracker | None = guide.tracker if guide else None
        self._navigator = navigator
        self._guide = guide
        self._goal = x, y
        self._progress = Progress(_STUCK_M, _STUCK_NS)
        self._nearest = 0, inf
        """When, and how near (m), it was nearest."""
        self._longest = 0.0
        """m of the ways by the plan since then."""

    def wish(self, situation: Situation) -> Twist:
        """As the navigator says."""
        if self.tracker and self.tracker.is_lost:
            return self._over(reached=False, told="lost: the echoes do not fit the map")
        here = self._guide.here(situation.pose) if self._guide else situation.pose
        goal = towards(here, *self._goal)
        if goal.distance <= ARRIVED:
            return self._over(reached=True, told=self._told("there", here))
        if self._guide:
            goal = self._guide.aim(situation.local, situation.pose, situation.now_ns, self._goal)
            self._longest = max(self._longest, goal.distance)
        moment = Moment(situation.now_ns, situation.pose, situation.twist)
        course = self._navigator.steer(situation.local, moment, goal, situation.elapsed_s)
        if self._is_stuck(situation, goal.distance):
            return self._over(reached=False, told=self._told("stuck", here))
        return course.twist

    def report(self) -> Mapping[str, Any]:
        """Where it is on the map, if there is one."""
        return {"on_map": self._guide.report()} if self._guide else {}

    def rest(self, now_ns: int) -> None:
        """Who can't drive is not stuck."""
        self._progress.forget()
        self._nearest = now_ns, self._nearest[1]

    def _is_stuck(self, situation: Situation, distance: float) -> bool:
        now_ns = situation.now_ns
        if distance < self._nearest[1] - _STUCK_M:
            self._nearest, self._longest = (now_ns, distance), 0.0
        astray = now_ns - self._nearest[0] >= _DETOUR_NS + round(self._longest * _NS_PER_M)
        stands = self._progress.lacking(now_ns, situation.pose)
        return astray or stands or self._navigator.recovery.stage is Stage.STUCK

    def _over(self, reached: bool, told: str) -> Twist:
        self.end = End(reached, told)
        return Twist()

    def _told(self, what: str, here: Pose) -> str:
        left = hypot(self._goal[0] - here.x, self._goal[1] - here.y)
        return f"{what}: x {here.x:.2f} m, y {here.y:.2f} m, {left:.2f} m from the goal"
