"""Who is near the robot and may walk into it: somebody who passes now may turn round the next moment.

Near whoever moves, or appeared where nothing stood, the robot is so slow that it stands before they could be
there, whichever way they go. `approach.py` sees who comes; a person who turns comes sooner than it is seen.
"""

from dataclasses import dataclass
from math import hypot, inf, sqrt

from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose
from echogrid.mapping.verification import heard_at

_WALKS = 0.8
"""m/s."""
_GONE_NS = 1_000_000_000
"""Who was not heard for so long is elsewhere."""
_RESTS_NS = 2_500_000_000
"""Who has not strayed for so long stands."""
_STRAYS = 0.25
"""m."""
_SAME = 0.5
"""m: two echoes no farther from each other may be of one person."""
_CLOSE = 1.6
"""m from the robot: within it, what appears is taken for somebody. Farther away it is too vague where an echo
came from."""
_SPOT = 0.4
"""m around an echo that are one spot."""
_STANDS_NS = 1_300_000_000
"""What was heard at one spot for so long, ..."""
PAUSE_NS = 700_000_000
"""... never silent for longer, ..."""
_KNOWN_NS = 15_000_000_000
"""... stands, and may be heard there anew for so long."""
_FORGET_NS = 5_000_000_000
"""Other spots are forgotten after that."""


@dataclass(slots=True)
class _Somebody:
    heard_ns: int
    x: float
    y: float
    anchor: tuple[int, float, float]
    """When and where they last strayed."""

    def is_near(self, now_ns: int) -> bool:
        """Whether they still count."""
        return now_ns - self.heard_ns < _GONE_NS and now_ns - self.anchor[0] < _RESTS_NS


@dataclass(slots=True)
class _Spot:
    since_ns: int
    heard_ns: int
    x: float
    y: float
    stands: bool = False

    def hear(self, stamp_ns: int, pause_ns: int) -> None:
        """Something answered here."""
        if stamp_ns - self.heard_ns > pause_ns:
            self.since_ns = stamp_ns
        self.heard_ns = stamp_ns
        self.stands = self.stands or stamp_ns - self.since_ns >= _STANDS_NS

    def is_known(self, now_ns: int) -> bool:
        """Whether it is not forgotten yet."""
        return now_ns - self.heard_ns < (_KNOWN_NS if self.stands else _FORGET_NS)


class Company:
    """Remembers where somebody may be, and where something stands. All is in the odom frame."""

    def __init__(self, radius: float, pause_ns: int = PAUSE_NS) -> None:
        """`radius` (m) is that of the robot around base_link; what stands is never silent for longer than
        `pause_ns`, some cycles of the rangers."""
        self._radius = radius
        self._pause_ns = pause_ns
        self._people: list[_Somebody] = []
        self._spots: list[_Spot] = []

    def take(self, ping: PlacedPing, moves: bool, strange: bool) -> None:
        """A ping; whether what it heard surely moves by itself, and whether all that stands here is known, so
        that what answers though no wall is there is strange."""
        distance, now_ns = heard_at(ping), ping.reading.stamp_ns
        if distance is None:
            return
        at = ping.transducer.compose(Pose(distance))
        self._people = [each for each in self._people if each.is_near(now_ns)]
        if strange and self._stands(at, now_ns):
            return
        appeared = strange and self._is_close(ping, distance)
        known = min(self._people, key=lambda each: hypot(at.x - each.x, at.y - each.y), default=None)
        if known is not None and hypot(at.x - known.x, at.y - known.y) < _SAME:
            known.heard_ns, known.x, known.y = now_ns, at.x, at.y
            if hypot(at.x - known.anchor[1], at.y - known.anchor[2]) > _STRAYS:
                known.anchor = now_ns, at.x, at.y
        elif moves or appeared:
            self._people.append(_Somebody(now_ns, at.x, at.y, (now_ns, at.x, at.y)))

    def limit(self, now_ns: int, robot: Pose, reaction_s: float, deceleration: float) -> float:
        """m/s from which the robot, whose wheels heed it `reaction_s` later, stands before anybody near
        could be there; inf if nobody is.

        v t + v^2/2a for the robot, w (t + v/a) for the person: together no more than the gap between them.
        """
        people = [each for each in self._people if each.is_near(now_ns)]
        if not people:
            return inf
        gap = min(
            hypot(each.x - robot.x, each.y - robot.y) - _WALKS * (now_ns - each.heard_ns) * 1e-9
            for each in people
        )
        room = gap - self._radius - _WALKS * reaction_s
        slope = reaction_s + _WALKS / deceleration
        return deceleration * (sqrt(slope**2 + 2.0 * max(room, 0.0) / deceleration) - slope)

    def _stands(self, at: Pose, now_ns: int) -> bool:
        """Whether something is known to stand where something answers now."""
        self._spots = [spot for spot in self._spots if spot.is_known(now_ns)]
        here = [spot for spot in self._spots if hypot(at.x - spot.x, at.y - spot.y) < _SPOT]
        for spot in here:
            spot.hear(now_ns, self._pause_ns)
        if not here:
            self._spots.append(_Spot(now_ns, now_ns, at.x, at.y))
        return any(spot.stands for spot in here)

    def _is_close(self, ping: PlacedPing, distance: float) -> bool:
        echo = ping.ranger.mount.compose(Pose(distance))
        return hypot(echo.x, echo.y) - self._radius < _CLOSE
