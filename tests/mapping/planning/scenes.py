"""Plans of walls, and a robot that goes by the planner alone and sees what its window shows."""

from dataclasses import dataclass
from math import cos, hypot, sin

import numpy as np

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.planning.planner import Planner, Planning
from echogrid.mapping.pose import Pose
from echogrid.mapping.sonar_model import NoEcho

RESOLUTION, CELLS = 0.1, 40
"""A window of 4 m: less than the traps."""
STEP_NS, STRIDE = 100_000_000, 0.05
Walls = list[tuple[float, float, float, float]]
"""From x, y to x, y, m; along an axis."""

U_TRAP: Walls = [(3.0, -2.0, 3.0, 2.0), (-1.0, 2.0, 3.0, 2.0), (-1.0, -2.0, 3.0, -2.0)]
ROOM: Walls = [
    (-2.0, -2.0, 2.0, -2.0),
    (-2.0, 2.0, 2.0, 2.0),
    (2.0, -2.0, 2.0, 2.0),
    (-2.0, -2.0, -2.0, 0.8),
    (-2.0, 1.7, -2.0, 2.0),
]
"""Its door is in the west."""
DEAD_END: Walls = [
    (-3.0, 0.7, 4.0, 0.7),
    (-3.0, -0.7, 0.0, -0.7),
    (1.2, -0.7, 4.0, -0.7),
    (4.0, -0.7, 4.0, 0.7),
]
"""A corridor with a side door in the south."""
CELL: Walls = [*ROOM, (-2.0, 0.8, -2.0, 1.7)]


def local_grid(cells: int = CELLS, resolution: float = RESOLUTION) -> LocalGrid:
    return LocalGrid(resolution, cells, 0.1, 15.0, NoEcho.WEAK)


def paint(local: LocalGrid, walls: Walls, robot: Pose, now_ns: int) -> None:
    """All within the window is seen, and sure."""
    local.centre(robot)
    geometry = local.geometry
    local.seen_ns[:] = now_ns
    local.grid.log_odds[:] = -2000
    x, y = geometry.x_centres[np.newaxis, :], geometry.y_centres[:, np.newaxis]
    half = 0.51 * geometry.resolution
    for west, south, east, north in walls:
        within = (x >= west - half) & (x <= east + half) & (y >= south - half) & (y <= north + half)
        local.grid.log_odds[within] = 2000


def clearance(walls: Walls, x: float, y: float) -> float:
    """m to the nearest wall."""
    return min(
        hypot(max(west - x, 0.0, x - east), max(south - y, 0.0, y - north))
        for west, south, east, north in walls
    )


@dataclass
class Walk:
    """How it went."""

    planner: Planner
    way: list[Pose]
    nearest: float
    """m, from the robot's middle to any wall."""

    @property
    def length(self) -> float:
        """m."""
        return (len(self.way) - 1) * STRIDE

    def ends_at(self, x: float, y: float) -> bool:
        return hypot(self.way[-1].x - x, self.way[-1].y - y) < 0.1


def walk(walls: Walls, start: Pose, goal: tuple[float, float], planning: Planning | None = None) -> Walk:
    """At 0.5 m/s straight to wherever it says, for 60 m at the most."""
    planner, local = Planner(planning), local_grid()
    robot, way, nearest, now_ns = start, [start], clearance(walls, start.x, start.y), 1_000_000_000
    while hypot(robot.x - goal[0], robot.y - goal[1]) >= 0.1 and len(way) < 60.0 / STRIDE:
        paint(local, walls, robot, now_ns)
        aim = planner.aim(local, robot, now_ns, goal)
        if not planner.reachable:
            break
        stride = min(STRIDE, aim.distance)
        robot = Pose(robot.x + stride * cos(aim.bearing), robot.y + stride * sin(aim.bearing), aim.bearing)
        way.append(robot)
        nearest = min(nearest, clearance(walls, robot.x, robot.y))
        now_ns += STEP_NS
    return Walk(planner, way, nearest)
