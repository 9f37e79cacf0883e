"""Whoever steers a robot by what it has sensed."""

from collections.abc import Callable
from dataclasses import dataclass
from math import radians
from typing import Protocol

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.planning.floor_plan import FloorPlan
from echogrid.mapping.planning.tracking import PlanTracker
from echogrid.mapping.pose import Pose
from echogrid.mapping.twist import Twist
from echogrid.runtime.config import Config

STANDING = Twist()


class Pilot(Protocol):
    """Steers towards a goal. Poses and grid are in the odom frame; the goal is in it, or in that of the floor
    plan, which is the same at the start."""

    @property
    def guarded(self) -> bool:
        """Whether only the safe part of what it asks for is driven, as the service does it."""
        ...

    @property
    def tracker(self) -> PlanTracker | None:
        """Where it takes itself to be on its floor plan; None if it has none and goes by its wheels."""
        ...

    def hear(self, ping: PlacedPing) -> None:
        """A reading and where its transducer was, as it comes in; the grid has it by the next step."""
        ...

    def step(self, now_ns: int, local: LocalGrid, pose: Pose, twist: Twist, goal: Pose) -> Twist:
        """What to drive from now on. `pose` is the odometry's, `twist` what the motors are asked for."""
        ...


@dataclass(frozen=True, slots=True)
class Robot:
    """What a pilot knows of the robot that it steers."""

    radius: float
    """m: nothing of it is farther from base_link."""
    config: Config
    """What its robot.toml says."""
    floor_plan: Callable[[bool], FloorPlan]
    """Of the place, in the frame in which the robot starts at zero; furnished or not."""

    @property
    def speed(self) -> float:
        """m/s, at most."""
        return self.config.drive.max_speed_mps

    @property
    def turn_rate(self) -> float:
        """rad/s, at most."""
        return radians(self.config.drive.max_turn_dps)

    @property
    def period_s(self) -> float:
        """From step to step."""
        return 1.0 / self.config.loop.rate_hz


Hiring = Callable[[Robot], Pilot]
"""What makes a pilot for a robot."""
