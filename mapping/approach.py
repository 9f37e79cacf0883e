"""What comes nearer by itself: people, and other robots.

A map of what stands tells of somebody who walks up to the robot when it is too late to stop; two echoes of
one ranger tell it before, three for certain.
"""

from dataclasses import dataclass
from math import cos, hypot, inf, sin

from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.verification import heard_at

_LATELY_NS = 400_000_000
_SLOWEST, _FASTEST = 0.3, 2.0
"""m/s along a ranger's axis: what is slower may stand, what is quicker was another thing."""
_TURNED = 0.15
"""rad between two pings of a ranger: beyond that it looks at something else."""
_SOON_S = 1.5
"""What surely comes, and will be here within that, is met standing."""
_HOLD_NS = 400_000_000


@dataclass(frozen=True, slots=True)
class _Echo:
    stamp_ns: int
    transducer: Pose
    distance: float
    """m."""
    comes: bool
    """Whether it was nearer by itself than the one before."""
    moves: bool
    """Whether it was nearer, or farther away, by itself."""


class Approach:
    """Remembers the last echo of each ranger, and when what moves will be at the robot."""

    def __init__(self, radius: float) -> None:
        """`radius` (m) is that of the robot around base_link."""
        self._radius = radius
        self._last: dict[str, _Echo] = {}
        self._met: list[tuple[int, int]] = []
        """Until when each counts, and when it is here, ns."""

    def take(self, ping: PlacedPing) -> bool:
        """A ping with its place (odom frame); whether what it heard surely moves: twice in a row."""
        distance, stamp_ns = heard_at(ping), ping.reading.stamp_ns
        before = self._last.pop(ping.ranger.name, None)
        if distance is None:
            return False
        closing, moves = (0.0, 0.0) if before is None else _speeds(before, ping, distance)
        seconds = self._seconds_left(ping, distance, closing, moves)
        walks = _SLOWEST <= abs(moves) <= _FASTEST
        self._last[ping.ranger.name] = _Echo(stamp_ns, ping.transducer, distance, seconds < inf, walks)
        if before is None:
            return False
        if seconds < inf:
            seconds = 0.0 if before.comes and seconds < _SOON_S else seconds
            self._met = [met for met in self._met if met[0] > stamp_ns]
            self._met.append((stamp_ns + _HOLD_NS, stamp_ns + round(seconds * 1e9)))
        return walks and before.moves

    def limit(self, now_ns: int, reaction_s: float, deceleration: float) -> float:
        """m/s from which the robot, whose wheels heed it `reaction_s` later, stands before what comes is
        there; inf if nothing does."""
        arrives_ns = min((arrives for until_ns, arrives in self._met if until_ns > now_ns), default=None)
        if arrives_ns is None:
            return inf
        return deceleration * max((arrives_ns - now_ns) * 1e-9 - reaction_s, 0.0)

    def _seconds_left(self, ping: PlacedPing, distance: float, closing: float, moves: float) -> float:
        """s until it is here, if it comes; else inf."""
        if not _SLOWEST <= moves <= _FASTEST:
            return inf
        echo = ping.ranger.mount.compose(Pose(distance))
        return max(hypot(echo.x, echo.y) - self._radius, 0.0) / max(closing, moves)


def _speeds(before: _Echo, ping: PlacedPing, distance: float) -> tuple[float, float]:
    """m/s with which it comes nearer to the ranger, and what of that is its own; 0 if nobody knows."""
    here, there = ping.transducer, before.transducer
    elapsed_ns = ping.reading.stamp_ns - before.stamp_ns
    if not 0 < elapsed_ns <= _LATELY_NS or abs(wrap_angle(here.yaw - there.yaw)) > _TURNED:
        return 0.0, 0.0
    own = (here.x - there.x) * cos(here.yaw) + (here.y - there.y) * sin(here.yaw)
    closing = (before.distance - distance) * 1e9 / elapsed_ns
    return closing, closing - own * 1e9 / elapsed_ns
