"""Whether a robot that is to get somewhere does."""

from math import hypot

from echogrid.mapping.pose import Pose


class Progress:
    """A robot that was nowhere farther than `way` (m) from where it was for `patience_ns` doesn't."""

    def __init__(self, way: float, patience_ns: int) -> None:
        self._way = way
        self._patience_ns = patience_ns
        self._anchor: tuple[int, Pose] | None = None

    def lacking(self, now_ns: int, pose: Pose) -> bool:
        """Whether it is time for something else; that is told once, and watched from there anew."""
        if self._anchor is None:
            self._anchor = now_ns, pose
        since_ns, begin = self._anchor
        got_on = hypot(pose.x - begin.x, pose.y - begin.y) > self._way
        late = now_ns - since_ns >= self._patience_ns
        if got_on or late:
            self._anchor = now_ns, pose
        return late and not got_on

    def forget(self) -> None:
        """Watch from the next time on."""
        self._anchor = None
