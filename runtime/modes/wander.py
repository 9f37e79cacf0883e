"""Wherever it is free."""

from math import pi
from random import Random

from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.steering.goal import Goal, ahead
from echogrid.mapping.steering.navigator import Moment, Navigator
from echogrid.mapping.steering.recovery import Stage
from echogrid.mapping.twist import Twist
from echogrid.runtime.modes.mode import End, Situation
from echogrid.runtime.modes.progress import Progress

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

    def __init__(self, navigator: Navigator, seed: int) -> None:
        self.end: End | None = None
        self._navigator = navigator
        self._random = Random(seed)
        self._progress = Progress(_BORED_M, _BORED_NS)
        self._blocked = False
        self._turn: tuple[int, float] | None = None
        """A new direction (rad, odom frame), and since when it is the goal."""

    def wish(self, situation: Situation) -> Twist:
        """As the navigator says."""
        now_ns, pose = situation.now_ns, situation.pose
        moment = Moment(now_ns, pose, situation.twist)
        course = self._navigator.steer(
            situation.local, moment, self._goal(now_ns, pose), situation.elapsed_s, situation.latency_s
        )
        blocked = self._navigator.recovery.stage is not Stage.NONE
        if self._progress.lacking(now_ns, pose) or (blocked and not self._blocked):
            self._turn = now_ns, self._random.uniform(-pi, pi)
        self._blocked = blocked
        return course.twist

    def rest(self, now_ns: int) -> None:
        """Who can't drive is not stuck."""
        self._progress.forget()

    def _goal(self, now_ns: int, pose: Pose) -> Goal:
        if self._turn is not None:
            since_ns, bearing = self._turn
            if abs(wrap_angle(bearing - pose.yaw)) > _TURNED and now_ns - since_ns < _TURN_NS:
                return Goal(bearing)
            self._turn = None
        return ahead(pose)
