"""Walls that go on: what a ranger that looks aside has heard twice is expected a little farther along, too.

A smooth wall is heard at right angles only. A robot that nears it at a slant hears of it from the side, never
from ahead, and the last echo is beside the robot when it touches.
"""

from math import cos, hypot, radians, sin

from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger

_FARTHEST = 1.2
_LATELY_NS = 500_000_000
_SHORTEST, _LONGEST = 0.02, 0.4
_ON = 3.5
_STEP = 0.05
_ABEAM = cos(radians(60.0))


class Walls:
    """Remembers the last echo of each ranger."""

    def __init__(self) -> None:
        self._last: dict[str, tuple[int, Pose, float, float]] = {}

    def ahead(self, transducer: Pose, ranger: Ranger, distance: float, stamp_ns: int) -> list[tuple[float, float]]:
        """Points where the wall that was just heard is expected to go on; empty if it is none."""
        if distance > _FARTHEST:
            self._last.pop(ranger.name, None)
            return []
        ex, ey = cos(transducer.yaw), sin(transducer.yaw)
        x, y = transducer.x + distance * ex, transducer.y + distance * ey
        before = self._last.get(ranger.name)
        self._last[ranger.name] = stamp_ns, transducer, x, y
        if before is None or stamp_ns - before[0] > _LATELY_NS:
            return []
        mx, my = transducer.x - before[1].x, transducer.y - before[1].y
        dx, dy = x - before[2], y - before[3]
        moved, along = hypot(mx, my), hypot(dx, dy)
        if not (_SHORTEST <= moved and _SHORTEST <= along <= _LONGEST):
            return []
        if abs(mx * ex + my * ey) > _ABEAM * moved or abs(dx * ex + dy * ey) > _ABEAM * along:
            return []
        count = int(_ON * along / _STEP)
        return [(x + dx / along * _STEP * k, y + dy / along * _STEP * k) for k in range(count + 1)]
