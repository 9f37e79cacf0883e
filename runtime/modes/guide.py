"""The way by a floor plan: where the robot is on it, and where to head for now."""

from dataclasses import dataclass
from math import degrees
from typing import Any

from echogrid.mapping.planning.planner import Planner
from echogrid.mapping.planning.tracking import PlanTracker
from echogrid.mapping.pose import Pose
from echogrid.mapping.steering.goal import Goal, Point
from echogrid.runtime.modes.mode import Situation


@dataclass(frozen=True, slots=True)
class Guide:
    """Both are in the plan's frame. The tracker is moved by the lookout, which has it, too."""

    tracker: PlanTracker
    planner: Planner

    def here(self, situation: Situation) -> Pose:
        """Of the robot (plan's frame)."""
        return self.tracker.drift.compose(situation.pose)

    def aim(self, situation: Situation, goal: Point) -> Goal:
        """Where to head for (odom frame), and how far the way is, to a goal in the plan's."""
        drift, here = self.tracker.drift, self.here(situation)
        return self.planner.aim(situation.local, here, situation.now_ns, goal, drift)

    def report(self) -> dict[str, Any]:
        """Where the robot is on the map, and the standard deviations of that."""
        pose, (x, y, yaw) = self.tracker.pose, self.tracker.deviation
        return {
            "x_m": round(pose.x, 3),
            "y_m": round(pose.y, 3),
            "yaw_deg": round(degrees(pose.yaw), 2),
            "deviation": {"x_m": round(x, 4), "y_m": round(y, 4), "yaw_deg": round(degrees(yaw), 3)},
        }
