"""The way that is planned: where to head for now, and where the robot is if it has a floor plan."""

from dataclasses import dataclass
from math import degrees
from typing import Any

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.planning.planner import Planner
from echogrid.mapping.planning.tracking import PlanTracker
from echogrid.mapping.pose import ORIGIN, Pose
from echogrid.mapping.steering.goal import Goal, Point


@dataclass(frozen=True, slots=True)
class Guide:
    """The tracker is moved by the lookout, which has it, too. Both are in the plan's frame."""

    planner: Planner
    tracker: PlanTracker | None = None
    """None without a plan: then all is in the odom frame."""

    def here(self, robot: Pose) -> Pose:
        """Of the robot (plan's frame), which is there by its wheels (odom frame)."""
        return self._drift.compose(robot)

    def aim(self, local: LocalGrid, robot: Pose, now_ns: int, goal: Point) -> Goal:
        """Where to head for, and how far the way is (odom frame, as grid and robot), to a goal (plan's)."""
        return self.planner.aim(local, self.here(robot), now_ns, goal, self._drift)

    def report(self) -> dict[str, Any]:
        """Where the robot is on the map, and the standard deviations of that."""
        if self.tracker is None:
            return {}
        pose, (x, y, yaw) = self.tracker.pose, self.tracker.deviation
        return {
            "x_m": round(pose.x, 3),
            "y_m": round(pose.y, 3),
            "yaw_deg": round(degrees(pose.yaw), 2),
            "deviation": {"x_m": round(x, 4), "y_m": round(y, 4), "yaw_deg": round(degrees(yaw), 3)},
        }

    @property
    def _drift(self) -> Pose:
        return self.tracker.drift if self.tracker else ORIGIN
