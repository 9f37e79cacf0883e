"""What comes nearer by itself: people, and other robots.

A map of what stands says too late that something walks up to the robot: two echoes of one ranger tell it.
"""

from math import cos, hypot, inf, sin

from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.verification import heard_at

_LATELY_NS = 400_000_000
_SLOWEST, _FASTEST = 0.3, 2.0
"""m/s along a ranger's axis: what is slower may stand, what is quicker was another thing."""
_TURNED = 0.15
"""rad between two pings: beyond it a ranger looks at something else."""


class Approach:
    """Remembers the last echo of each ranger, and when what moves will be here."""

    def __init__(self, radius: float, patience_s: float = 1.5, hold_ns: int = 400_000_000) -> None:
        self._radius = radius
        self._patience_s = patience_s
        self._hold_ns = hold_ns
        self._last: dict[str, tuple[int, Pose, float, bool]] = {}
        self._met: list[tuple[int, float]] = []

    def take(self, ping: PlacedPing) -> None:
        """A ping with its place (odom frame)."""
        distance, name, stamp_ns = heard_at(ping), ping.ranger.name, ping.reading.stamp_ns
        before = self._last.pop(name, None)
        if distance is None:
            return
        seconds = inf if before is None else self._seconds(before, ping, distance)
        self._last[name] = stamp_ns, ping.transducer, distance, seconds < inf
        if before is None or seconds == inf:
            return
        if before[3] and seconds < self._patience_s:
            seconds = 0.0
        self._met = [each for each in self._met if each[0] > stamp_ns]
        self._met.append((stamp_ns + self._hold_ns, seconds))

    def seconds(self, now_ns: int) -> float:
        """s until something is where the robot is."""
        return min((seconds for until_ns, seconds in self._met if until_ns > now_ns), default=inf)

    def _seconds(self, before: tuple[int, Pose, float, bool], ping: PlacedPing, distance: float) -> float:
        stamp_ns, there, former, _ = before
        elapsed_ns, here = ping.reading.stamp_ns - stamp_ns, ping.transducer
        if not 0 < elapsed_ns <= _LATELY_NS or abs(wrap_angle(here.yaw - there.yaw)) > _TURNED:
            return inf
        own = (here.x - there.x) * cos(here.yaw) + (here.y - there.y) * sin(here.yaw)
        closing = (former - distance) / (elapsed_ns * 1e-9)
        moves = closing - own / (elapsed_ns * 1e-9)
        if not _SLOWEST <= moves <= _FASTEST:
            return inf
        mount = ping.ranger.mount
        away = hypot(mount.x + distance * cos(mount.yaw), mount.y + distance * sin(mount.yaw)) - self._radius
        return max(away, 0.0) / max(closing, moves)
