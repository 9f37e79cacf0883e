"""Watches a drive from outside: when it is over, and what became of it."""

from collections.abc import Iterable
from dataclasses import replace
from math import hypot

from echogrid.emulation.hearing import Outing
from echogrid.emulation.plant import Plant
from echogrid.mapping.pose import Pose
from echogrid.mapping.twist import Twist
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.trials.course import GOAL_M, Course
from echogrid.runtime.trials.detection import Detection
from echogrid.runtime.trials.pinging import Fired
from echogrid.runtime.trials.rigs import Rig
from echogrid.runtime.trials.track import Track
from echogrid.runtime.trials.verdict import Bump, Verdict, Watch

_PATIENCE = 4.0
"""So many times as long as the shortest way takes at full speed,"""
_GRACE_S = 30.0
"""and so much more, it may take."""
_STUCK_NS = 20 * SECOND_NS
_STUCK_M = 0.3
"""Who was nowhere farther than this for so long is stuck."""


class Judge:
    """Of one drive, which begins at `started_ns` of the plant's time."""

    def __init__(self, course: Course, rig: Rig, outing: Outing, plant: Plant, started_ns: int = 0) -> None:
        self.track = Track()
        self.goal = Pose(*course.start).inverse().compose(Pose(*course.goal))
        """In the odom frame."""
        self._course = course
        self._plant = plant
        self._started_ns = started_ns
        self._detection = Detection(rig, outing, plant)
        self._watch = Watch()
        self._at_best_s = course.shortest / rig.drive.speed
        self._anchor = started_ns, course.start
        self._heard = 0

    def hear(self, stamps_ns: Iterable[int], now_ns: int) -> None:
        """Readings of these stamps are heeded from now on."""
        before = len(self._watch.latencies_ns)
        self._watch.latencies_ns += [now_ns - stamp_ns for stamp_ns in stamps_ns]
        self._heard += len(self._watch.latencies_ns) - before

    def see(self, believed: Pose, asked: Twist) -> None:
        """A step is done: the robot believes to be there, and asks its motors for that."""
        plant = self._plant
        clearance = plant.gaps().least
        self._watch.see(clearance, plant.speed)
        by_wheels = (believed.x, believed.y, believed.yaw)
        time_s = (plant.now_ns - self._started_ns) * 1e-9
        self.track.step((time_s, *plant.pose, *by_wheels, asked.speed, asked.turn_rate, clearance))

    def outcome(self, believed: Pose) -> str:
        """What became of it; nothing yet: ""."""
        now_ns, (x, y, yaw) = self._plant.now_ns, self._plant.pose
        if hypot(believed.x - self.goal.x, believed.y - self.goal.y) <= GOAL_M:
            return "reached"
        since_ns, (from_x, from_y, _) = self._anchor
        if hypot(x - from_x, y - from_y) > _STUCK_M:
            self._anchor = now_ns, (x, y, yaw)
        elif now_ns - since_ns >= _STUCK_NS:
            return "stuck"
        last_ns = self._started_ns + round((_PATIENCE * self._at_best_s + _GRACE_S) * SECOND_NS)
        return "late" if now_ns >= last_ns else ""

    def verdict(self, outcome: str, fired: Iterable[Fired]) -> Verdict:
        """Its figures, as it is over now; `fired` are the pings, in order."""
        plant, watch = self._plant, self._watch
        time_s = (plant.now_ns - self._started_ns) * 1e-9
        least, low = watch.clearance()
        x, y, _ = plant.pose
        return Verdict(
            outcome=outcome,
            time_s=time_s,
            travelled=plant.travelled,
            shortest=self._course.shortest,
            time_ratio=time_s / self._at_best_s,
            goal_error=hypot(x - self._course.goal[0], y - self._course.goal[1]),
            least_clearance=least,
            low_clearance=low,
            near_misses=watch.near_misses,
            reversals=watch.reversals,
            latency_s=watch.latency_s(),
            pings=self._heard,
            digest=self.track.digest(),
            bumps=self._bumps(list(fired)),
        )

    def _bumps(self, fired: list[Fired]) -> tuple[Bump, ...]:
        return tuple(
            Bump.judged(
                replace(contact, stamp_ns=contact.stamp_ns - self._started_ns),
                self._detection.possible(contact, reversed(fired)),
            )
            for contact in self._plant.contacts
        )
