"""Walls that go on: what a ranger that looks aside has heard twice is expected a little farther along, too.

A smooth wall is heard at right angles only. A robot that nears one at a slant hears it from the side and
never from ahead: the last echo is beside the robot when it touches what comes next.
"""

from dataclasses import dataclass
from math import cos, hypot, radians, sin

from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger

Point = tuple[float, float]

_FARTHEST = 1.2
"""m: what is farther away is not met before it is heard again."""
_LATELY_NS = 500_000_000
_SHORTEST, _LONGEST = 0.02, 0.4
"""m between two echoes: less has no direction, more was another wall."""
_ON = 3.5
"""Times as long as the way between two echoes a wall is expected to go on."""
_STEP = 0.05
"""m between the points."""
_ABEAM = cos(radians(60.0))
"""Of the angle to the ranger's axis, at least: of the way that it went, and of the wall."""


@dataclass(frozen=True, slots=True)
class _Echo:
    stamp_ns: int
    transducer: Pose
    x: float
    y: float


class Walls:
    """Remembers the last near echo of each ranger. All is in the frame of the transducers' poses."""

    def __init__(self) -> None:
        self._last: dict[str, _Echo] = {}

    def beyond(self, transducer: Pose, ranger: Ranger, echo_distance: float, stamp_ns: int) -> list[Point]:
        """Points, from the new echo on, where the wall that was heard goes on; none if it is no wall."""
        before = self._last.pop(ranger.name, None)
        if echo_distance > _FARTHEST:
            return []
        ahead = transducer.compose(Pose(echo_distance))
        echo = self._last[ranger.name] = _Echo(stamp_ns, transducer, ahead.x, ahead.y)
        if before is None or stamp_ns - before.stamp_ns > _LATELY_NS:
            return []
        went = transducer.x - before.transducer.x, transducer.y - before.transducer.y
        along = echo.x - before.x, echo.y - before.y
        length = hypot(*along)
        if length > _LONGEST or not (_is_abeam(transducer.yaw, went) and _is_abeam(transducer.yaw, along)):
            return []
        steps = [k * _STEP / length for k in range(int(_ON * length / _STEP) + 1)]
        return [(echo.x + step * along[0], echo.y + step * along[1]) for step in steps]


def _is_abeam(yaw: float, way: Point) -> bool:
    """Whether a way is long enough to have a direction, and leads across an axis."""
    length = hypot(*way)
    return length >= _SHORTEST and abs(way[0] * cos(yaw) + way[1] * sin(yaw)) <= _ABEAM * length
