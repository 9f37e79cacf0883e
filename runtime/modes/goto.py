"""Towards a point, past what stands in the way."""

from math import hypot

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


class Goto:
    """Ends at the goal (m, odom frame), or where it gets on no more."""

    name = "goto"
    patient = False

    def __init__(self, navigator: Navigator, x: float, y: float) -> None:
        self.end: End | None = None
        self._navigator = navigator
        self._goal = x, y
        self._progress = Progress(_STUCK_M, _STUCK_NS)

    def wish(self, situation: Situation) -> Twist:
        """As the navigator says."""
        goal = towards(situation.pose, *self._goal)
        if goal.distance <= ARRIVED:
            return self._over(situation, reached=True)
        moment = Moment(situation.now_ns, situation.pose, situation.twist)
        course = self._navigator.steer(
            situation.local, moment, goal, situation.elapsed_s, situation.latency_s
        )
        tried = self._navigator.recovery.stage is Stage.STUCK
        if self._progress.lacking(situation.now_ns, situation.pose) or tried:
            return self._over(situation, reached=False)
        return course.twist

    def close(self) -> None:
        """It holds nothing."""

    def _over(self, situation: Situation, reached: bool) -> Twist:
        x, y = situation.pose.x, situation.pose.y
        left = hypot(self._goal[0] - x, self._goal[1] - y)
        what = "there" if reached else "stuck"
        self.end = End(reached, f"{what}: x {x:.2f} m, y {y:.2f} m, {left:.2f} m from the goal")
        return Twist()
