"""Where the robot was: poses by time, interpolated at the moment of a ping."""

from bisect import bisect_left, bisect_right
from enum import Enum

from echogrid.mapping.pose import Pose, interpolate


class PoseMiss(Enum):
    """Why there is no pose at a stamp."""

    NOT_YET = "newer than the last pose"
    BEFORE = "outside the pose span"
    GAP = "pose gap"


class PoseBuffer:
    """Poses in order of time, the oldest forgotten; between two of them it interpolates, beyond it does not.

    It reaches back `keep_ns` at least (None: for ever). Neighbours further apart than `widest_gap_ns` are not
    interpolated: nobody knows what the robot did between them.
    """

    def __init__(self, keep_ns: int | None = 10_000_000_000, widest_gap_ns: int = 500_000_000) -> None:
        self._keep_ns = keep_ns
        self._widest_gap_ns = widest_gap_ns
        self._stamps: list[int] = []
        self._poses: list[Pose] = []

    @property
    def newest(self) -> tuple[int, Pose] | None:
        """The last stamp and pose, if there is any."""
        return (self._stamps[-1], self._poses[-1]) if self._stamps else None

    def add(self, stamp_ns: int, pose: Pose) -> bool:
        """Take a pose; False, and nothing taken, unless it is later than the last one."""
        if self._stamps and stamp_ns <= self._stamps[-1]:
            return False
        self._stamps.append(stamp_ns)
        self._poses.append(pose)
        self._forget()
        return True

    def at(self, stamp_ns: int) -> Pose | PoseMiss:
        """The pose at a stamp, or why there is none."""
        if not self._stamps or stamp_ns > self._stamps[-1]:
            return PoseMiss.NOT_YET
        after = bisect_left(self._stamps, stamp_ns)
        if self._stamps[after] == stamp_ns:
            return self._poses[after]
        if after == 0:
            return PoseMiss.BEFORE
        start_ns, end_ns = self._stamps[after - 1], self._stamps[after]
        if end_ns - start_ns > self._widest_gap_ns:
            return PoseMiss.GAP
        fraction = (stamp_ns - start_ns) / (end_ns - start_ns)
        return interpolate(self._poses[after - 1], self._poses[after], fraction)

    def _forget(self) -> None:
        """Drop what is too old, a batch at a time."""
        if self._keep_ns is None or len(self._stamps) < 256:
            return
        old = bisect_right(self._stamps, self._stamps[-1] - self._keep_ns) - 1
        if old > len(self._stamps) // 2:
            del self._stamps[:old], self._poses[:old]
