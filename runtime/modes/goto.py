"""Towards a point, past what stands in the way."""

from collections.abc import Mapping
from math import hypot, inf
from typing import Any

from echogrid.mapping.steering.goal import towards
from echogrid.mapping.steering.navigator import Moment, Navigator
from echogrid.mapping.steering.recovery import Stage
from echogrid.mapping.twist import Twist
from echogrid.runtime.modes.mode import End, Situation
from echogrid.runtime.modes.progress import Progress

ARRIVED = 0.15
"""m: so near it is there."""
_STUCK_M = 0.3
_STUCK_NS = 20_000_000_000
_DETOUR_NS = 90_000_000_000
"""So long it may take to come nearer to the goal than it ever was."""


class Goto:
    """Ends at the goal (m, odom frame), or where it gets on no more."""

    name = "goto"
    patient = False

    def __init__(self, navigator: Navigator, x: float, y: float) -> None:
        self.end: End | None = None
        self._navigator = navigator
        self._goal = x, y
        self._progress = Progress(_STUCK_M, _STUCK_NS)
        self._nearest = 0, inf
        """When, and how near (m), it was nearest."""

    def wish(self, situation: Situation) -> Twist:
        """As the navigator says."""
        goal = towards(situation.pose, *self._goal)
        if goal.distance <= ARRIVED:
            return self._over(situation, reached=True)
        moment = Moment(situation.now_ns, situation.pose, situation.twist)
        course = self._navigator.steer(situation.local, moment, goal, situation.elapsed_s)
        if self._is_stuck(situation, goal.distance):
            return self._over(situation, reached=False)
        return course.twist

    def report(self) -> Mapping[str, Any]:
        """Nothing."""
        return {}

    def rest(self, now_ns: int) -> None:
        """Who can't drive is not stuck."""
        self._progress.forget()
        self._nearest = now_ns, self._nearest[1]

    def _is_stuck(self, situation: Situation, distance: float) -> bool:
        now_ns = situation.now_ns
        if distance < self._nearest[1] - _STUCK_M:
            self._nearest = now_ns, distance
        astray = now_ns - self._nearest[0] >= _DETOUR_NS
        stands = self._progress.lacking(now_ns, situation.pose)
        return astray or stands or self._navigator.recovery.stage is Stage.STUCK

    def _over(self, situation: Situation, reached: bool) -> Twist:
        x, y = situation.pose.x, situation.pose.y
        left = hypot(self._goal[0] - x, self._goal[1] - y)
        what = "there" if reached else "stuck"
        self.end = End(reached, f"{what}: x {x:.2f} m, y {y:.2f} m, {left:.2f} m from the goal")
        return Twist()
