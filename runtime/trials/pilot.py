"""Whoever steers a robot by what it has sensed."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.twist import Twist

STANDING = Twist()


class Pilot(Protocol):
    """Steers towards a goal. Poses, goal and grid are in the odom frame."""

    def hear(self, ping: PlacedPing) -> None:
        """A reading and where its transducer was, as it comes in; the grid has it by the next step."""
        ...

    def step(self, now_ns: int, local: LocalGrid, pose: Pose, twist: Twist, goal: Pose) -> Twist:
        """What to drive from now on: `pose` and `twist` are those of the odometry."""
        ...


@dataclass(frozen=True, slots=True)
class Robot:
    """What a pilot knows of the robot that it steers."""

    radius: float
    """m: nothing of it is farther from base_link."""
    rangers: tuple[Ranger, ...]
    speed: float
    """m/s, at most."""
    turn_rate: float
    """rad/s, at most."""
    acceleration: float
    """m/s^2."""
    turn_acceleration: float
    """rad/s^2."""
    period_s: float
    """From step to step."""


Hiring = Callable[[Robot], Pilot]
"""What makes a pilot for a robot."""
