"""Pilots without a map, to be compared with: one is blind, the other heeds each ranger's last echo."""

from dataclasses import dataclass, field
from math import asin, atan2, cos, hypot, pi
from typing import ClassVar

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.twist import Twist
from echogrid.mapping.verification import heard_at
from echogrid.runtime.trials.pilot import STANDING, Robot

_ARRIVED = 0.15
"""m: then it stops."""
_TURN_GAIN = 2.0
"""rad/s for each rad that it looks away."""
_FRESH_NS = 500_000_000
"""What is older was another scan."""
_DIRECTIONS = 72
_LOOKED_AT = 1.2
"""m from base_link: echoes from farther away block nothing."""
_SPACE = 0.1
"""m that it keeps from what it hears."""
_HABIT = 0.3
"""How much a turn costs against a way that leads away from the goal."""
_SQUEEZED = 0.5 * pi
"""rad: an echo nearer than the robot's own reach blocks so much to either side."""
_ABEAM = 0.55 * pi
"""rad: what is farther behind does not slow it down."""
_CRAWL = 0.1
"""m/s."""
_STILL = 0.01
"""m/s: who is slower stands."""
_BALKED = 8
"""Steps in which it stands though it should go: then something holds it that it is too near to hear."""
_RETREAT = 24
"""Steps: it backs off for the first half of them, and turns for the rest."""


def towards(robot: Robot, bearing: float, speed: float) -> Twist:
    """Turn there, and drive the less the more is left to turn."""
    turn_rate = min(max(_TURN_GAIN * bearing, -robot.turn_rate), robot.turn_rate)
    return Twist(speed * max(cos(bearing), 0.0) ** 2, turn_rate)


def to_goal(pose: Pose, goal: Pose) -> tuple[float, float]:
    """Distance, m, and bearing, rad, of the goal."""
    dx, dy = goal.x - pose.x, goal.y - pose.y
    return hypot(dx, dy), wrap_angle(atan2(dy, dx) - pose.yaw)


@dataclass(frozen=True, slots=True)
class Blind:
    """Drives straight at the goal."""

    robot: Robot
    guarded: ClassVar[bool] = False
    tracker: ClassVar[None] = None

    def hear(self, ping: PlacedPing) -> None:
        """It does not."""

    def step(self, now_ns: int, local: LocalGrid, pose: Pose, twist: Twist, goal: Pose) -> Twist:
        """Go."""
        del now_ns, local, twist
        distance, bearing = to_goal(pose, goal)
        return STANDING if distance < _ARRIVED else towards(self.robot, bearing, self.robot.speed)


@dataclass(slots=True)
class SingleScan:
    """Takes, of the directions that no ranger's last echo blocks, the one nearest the goal's.

    An echo is where the ranger's axis is; it blocks what the robot is too wide for. It remembers nothing
    else, but that it was held up.
    """

    robot: Robot
    guarded: ClassVar[bool] = False
    tracker: ClassVar[None] = None
    _echoes: dict[str, tuple[int, float, float]] = field(default_factory=dict)
    """Of each ranger: stamp, and place in the odom frame (m)."""
    _was: Pose | None = None
    """Where it was a step ago."""
    _held: int = 0
    """Steps for which it has been."""
    _retreat: int = 0
    """Steps that are left of it."""

    def hear(self, ping: PlacedPing) -> None:
        """Keep the echo, or forget it."""
        distance = heard_at(ping)
        if distance is None:
            self._echoes.pop(ping.ranger.name, None)
            return
        echo = ping.transducer.compose(Pose(distance))
        self._echoes[ping.ranger.name] = ping.reading.stamp_ns, echo.x, echo.y

    def step(self, now_ns: int, local: LocalGrid, pose: Pose, twist: Twist, goal: Pose) -> Twist:
        """Choose a direction, and be slow where something is near; back off where it is held."""
        del local, twist
        distance, bearing = to_goal(pose, goal)
        stands = self._was is not None and to_goal(pose, self._was)[0] < _STILL * self.robot.period_s
        self._was = pose
        if distance < _ARRIVED:
            return STANDING
        if self._retreat:
            self._retreat -= 1
            return Twist(-_CRAWL) if self._retreat > _RETREAT // 2 else Twist(0.0, 0.5 * self.robot.turn_rate)
        near = [
            to_goal(pose, Pose(x, y))
            for stamp_ns, x, y in self._echoes.values()
            if now_ns - stamp_ns <= _FRESH_NS
        ]
        asked = self._asked([each for each in near if each[0] < min(_LOOKED_AT, distance)], distance, bearing)
        self._held = self._held + 1 if asked.speed >= 0.5 * _CRAWL and stands else 0
        if self._held >= _BALKED:
            self._held, self._retreat = 0, _RETREAT
        return asked

    def _asked(self, near: list[tuple[float, float]], distance: float, bearing: float) -> Twist:
        chosen = self._chosen(near, bearing)
        if chosen is None:
            return Twist(0.0, 0.5 * self.robot.turn_rate)
        nearest = min((far for far, side in near if abs(side) < _ABEAM), default=_LOOKED_AT)
        room = max(nearest - self.robot.radius - _SPACE, _CRAWL)
        return towards(self.robot, chosen, min(self.robot.speed, room, distance))

    def _chosen(self, near: list[tuple[float, float]], bearing: float) -> float | None:
        """rad: the open direction that costs least; None if there is none."""
        wide = self.robot.radius + _SPACE
        blocked = [(side, asin(wide / far) if far > wide else _SQUEEZED) for far, side in near]
        directions = [bearing, *(wrap_angle(2.0 * pi * k / _DIRECTIONS) for k in range(_DIRECTIONS))]
        open_ones = [
            each for each in directions if all(abs(wrap_angle(each - side)) > half for side, half in blocked)
        ]
        return min(
            open_ones, key=lambda each: abs(wrap_angle(each - bearing)) + _HABIT * abs(each), default=None
        )
