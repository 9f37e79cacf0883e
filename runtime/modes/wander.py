"""Wherever it is free."""

from collections.abc import Mapping
from math import pi, radians
from random import Random
from typing import Any

from echogrid.mapping.planning.tracking import PlanTracker
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.steering.decision import Decision
from echogrid.mapping.steering.goal import Goal, ahead
from echogrid.mapping.steering.navigator import Moment, Navigator
from echogrid.mapping.twist import Twist
from echogrid.runtime.modes.mode import End, Situation
from echogrid.runtime.modes.progress import Progress

_ASIDE = radians(60.0)
"""Who must turn by more than this is blocked."""
_TURNED = 0.35
"""rad: so well turned to a new direction it goes straight on."""
_TURN_NS = 10_000_000_000
"""After so long, too."""
_BORED_M = 0.3
_BORED_NS = 8_000_000_000


class Wander:
    """Straight on; where that is blocked, or leads nowhere, in a direction by chance. It never ends."""

    name = "wander"
    patient = True
    tracker: PlanTracker | None = None

    def __init__(self, navigator: Navigator, seed: int) -> None:
        self.end: End | None = None
        self._navigator = navigator
        self._random = Random(seed)
        self._progress = Progress(_BORED_M, _BORED_NS)
        self._turn: tuple[int, float] | None = None
        """A new direction (rad, odom frame), and since when it is the goal."""

    def wish(self, situation: Situation) -> Twist:
        """As the navigator says."""
        now_ns, pose = situation.now_ns, situation.pose
        moment = Moment(now_ns, pose, situation.twist)
        goal = self._goal(now_ns, pose)
        course = self._navigator.steer(situation.local, moment, goal, situation.elapsed_s)
        blocked = self._turn is None and not _leads_on(course.decision, pose)
        if self._progress.lacking(now_ns, pose) or blocked:
            self._turn = now_ns, self._random.uniform(-pi, pi)
        return course.twist

    def report(self) -> Mapping[str, Any]:
        """Nothing."""
        return {}

    def rest(self, _now_ns: int) -> None:
        """Who can't drive is not stuck."""
        self._progress.forget()

    def _goal(self, now_ns: int, pose: Pose) -> Goal:
        if self._turn is not None:
            since_ns, bearing = self._turn
            if abs(wrap_angle(bearing - pose.yaw)) > _TURNED and now_ns - since_ns < _TURN_NS:
                return Goal(bearing)
            self._turn = None
        return ahead(pose)


def _leads_on(decision: Decision, pose: Pose) -> bool:
    """Whether the heading is about straight ahead."""
    return decision.heading is not None and abs(wrap_angle(decision.heading - pose.yaw)) <= _ASIDE
