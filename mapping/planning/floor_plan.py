"""What is known of a place before the robot drives there: where walls stand, and what is free."""

from dataclasses import dataclass, field
from math import cos, floor, sin

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.pose import Pose

Points = NDArray[np.float64]
"""(n, 2) x and y, m."""

SPACING = 0.05
"""m: the points of a wall are no farther from each other."""
_TILE = 0.5
"""m: what is near is looked up by squares of that size."""


@dataclass(frozen=True, eq=False)
class FloorPlan:
    """Points in the plan's frame."""

    walls: Points
    """Of what stands, seen from where one can be."""
    free: Points
    """Of what is free; no farther from each other than a planner's cells are wide."""
    _near: dict[tuple[int, int, int], Points] = field(default_factory=dict)

    def near(self, x: float, y: float, reach: float) -> Points:
        """The walls' points within `reach` (m) of a place, and some that are farther away."""
        tile = floor(x / _TILE), floor(y / _TILE), floor(reach / _TILE) + 1
        if tile not in self._near:
            middle = (tile[0] + 0.5) * _TILE, (tile[1] + 0.5) * _TILE
            away = np.hypot(*(self.walls - middle).T)
            self._near[tile] = self.walls[away <= (tile[2] + 1) * _TILE]
        return self._near[tile]

    def without(self, x: float, y: float, radius: float) -> "FloorPlan":
        """The same without what stands within a radius (m) of a place: the robot does."""
        away = np.hypot(self.walls[:, 0] - x, self.walls[:, 1] - y)
        return FloorPlan(self.walls[away > radius], self.free)


def placed(points: Points, frame: Pose) -> Points:
    """Points of a frame in that in which the frame's pose is given."""
    c, s = cos(frame.yaw), sin(frame.yaw)
    x, y = points[:, 0], points[:, 1]
    return np.column_stack((frame.x + c * x - s * y, frame.y + s * x + c * y))
