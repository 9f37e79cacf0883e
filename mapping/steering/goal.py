"""Where to: a direction in the grid's frame, and how far along it."""

from dataclasses import dataclass
from math import atan2, hypot, inf

from echogrid.mapping.pose import Pose, wrap_angle

Point = tuple[float, float]
"""x and y, m."""


@dataclass(frozen=True, slots=True)
class Goal:
    """As the robot sees it now."""

    bearing: float
    """rad, in the grid's frame (not from straight ahead)."""
    distance: float = inf
    """m; inf if it is a direction only."""
    way: tuple[Point, ...] = ()
    """Points (m, the grid's frame) of the way ahead, the nearest first, if there is a plan."""
    near: float = inf
    """m to the point of the way in that direction."""


def towards(robot: Pose, x: float, y: float) -> Goal:
    """The goal that is a point (m) of the grid's frame."""
    return Goal(atan2(y - robot.y, x - robot.x), hypot(x - robot.x, y - robot.y))


def ahead(robot: Pose, bearing: float = 0.0) -> Goal:
    """The goal that is a direction (rad) from straight ahead of the robot."""
    return Goal(wrap_angle(robot.yaw + bearing))
