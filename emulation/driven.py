"""A robot that goes where its two motors turn its wheels."""

from collections import deque
from math import cos, sin

from echogrid.emulation.devices.shaft import MotorShaft

Pose = tuple[float, float, float]
"""x, y (m) and unwrapped yaw (rad)."""

_STEP_NS = 5_000_000
_KEPT = 4000
"""Steps: it can be asked where it was 20 s ago."""


class DrivenBase:
    """A differential drive. Nothing stops it but its motors: it drives through walls."""

    def __init__(self, start: Pose, started_ns: int, radii: tuple[float, float], track: float) -> None:
        """`radii` are those of the left and the right wheel, m, as is the track."""
        self.left = MotorShaft()
        self.right = MotorShaft()
        self._radii = radii
        self._track = track
        self._poses: deque[tuple[int, Pose]] = deque([(started_ns, start)], _KEPT)
        for shaft in (self.left, self.right):
            shaft.changed = self._changed

    def pose(self, now_ns: int) -> Pose:
        """Where it is; of what is to come, where it would be if its motors went on as they do."""
        while (latest_ns := self._poses[-1][0]) + _STEP_NS <= now_ns:
            pose = self._led_on(*self._poses[-1], latest_ns + _STEP_NS)
            self._poses.append((latest_ns + _STEP_NS, pose))
        steps = (now_ns - self._poses[0][0]) // _STEP_NS
        start_ns, start = self._poses[min(max(steps, 0), len(self._poses) - 1)]
        return self._led_on(start_ns, start, max(now_ns, start_ns))

    def _led_on(self, start_ns: int, pose: Pose, end_ns: int) -> Pose:
        """The pose after a while, along the mean heading."""
        left = (self.left(end_ns) - self.left(start_ns)) * self._radii[0]
        right = (self.right(end_ns) - self.right(start_ns)) * self._radii[1]
        way, turn = (left + right) / 2.0, (right - left) / self._track
        heading = pose[2] + turn / 2.0
        return pose[0] + way * cos(heading), pose[1] + way * sin(heading), pose[2] + turn

    def _changed(self, now_ns: int) -> None:
        """Forget what was foreseen, and go up to now."""
        while len(self._poses) > 1 and self._poses[-1][0] > now_ns:
            self._poses.pop()
        self.pose(now_ns)
