"""A room of which there is a plan, and a robot with a ring of rangers that hears its walls."""

from dataclasses import dataclass, replace
from math import ceil, cos, hypot, pi, radians, sin

import numpy as np

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.emulation.hearing import Outing, scene_of
from echogrid.emulation.hearing import Ranger as Ear
from echogrid.emulation.transducers import POLAROID
from echogrid.emulation.world import World
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.planning.floor_plan import SPACING, FloorPlan
from echogrid.mapping.planning.tracking import PlanTracker
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger

CORNERS = [(-2.5, -2.0), (3.0, -2.0), (3.0, 0.5), (2.0, 0.5), (2.0, 2.2), (-2.5, 2.2)]
"""m; an L, so that it looks different from each of its sides."""
WALLS = np.array([(*CORNERS[n - 1], *CORNERS[n]) for n in range(len(CORNERS))])
ROOM = World("room", WALLS, np.zeros(len(WALLS), np.bool_), np.empty((0, 3)))
BEARINGS = [2.0 * pi * n / 16 for n in range(16)]
RING = [
    Ranger(f"ring {n}", Pose(0.08 * cos(b), 0.08 * sin(b), b), radians(15.0), 0.15, 4.0)
    for n, b in enumerate(BEARINGS)
]
EARS = [
    Ear(each.name, (each.mount.x, each.mount.y, each.mount.yaw), replace(POLAROID, reach=4.0))
    for each in RING
]
CYCLE_NS = 140_000_000
"""In which each ranger pings once."""
LOOP_M = 1.0
"""The radius of the circle that the robot drives on, around the origin."""
SPEED = 0.4
"""m/s."""


def dotted(walls: np.ndarray = WALLS) -> FloorPlan:
    """A plan of walls (n, 4), nothing of which is free."""
    points = []
    for x0, y0, x1, y1 in walls.tolist():
        count = ceil(hypot(x1 - x0, y1 - y0) / SPACING) + 1
        points.append(np.column_stack((np.linspace(x0, x1, count), np.linspace(y0, y1, count))))
    return FloorPlan(np.concatenate(points), np.empty((0, 2)))


PLAN = dotted()


@dataclass(frozen=True)
class Wheels:
    """What is wrong with them."""

    scale: float = 0.0
    """The part by which they count too much."""
    bend: float = 0.0
    """rad per metre that they turn without telling."""


def true_pose(way: float) -> Pose:
    """Where the robot is after so many metres."""
    angle = way / LOOP_M
    return Pose(LOOP_M * sin(angle), -LOOP_M * cos(angle), angle)


START = true_pose(0.0)


def told(wheels: Wheels, odometry: Pose, way: float) -> Pose:
    """The odometry after a way of which it made out this much before; a robot that drives round the loop."""
    counted = way * (1.0 + wheels.scale)
    turn = way / LOOP_M - wheels.bend * way
    step = Pose(counted * cos(turn / 2.0), counted * sin(turn / 2.0), turn)
    return odometry.compose(step)


@dataclass(frozen=True)
class Went:
    """How it was with a tracker on its way."""

    mean: float
    """m that it was off."""
    most: float
    lost: bool
    """Whether it ever said so."""
    truth: Pose


def drive(tracker: PlanTracker, wheels: Wheels, metres: float, seed: int | None = 1) -> Went:
    """Round the loop."""
    outing = Outing(ROOM, lambda now_ns: _tuple(true_pose(SPEED * now_ns * 1e-9)), seed)
    scenes = [scene_of(outing, ear) for ear in EARS]
    odometry, way, off, lost = Pose(), 0.0, [], False
    for tick in range(1, ceil(4.0 * metres / SPEED / (CYCLE_NS * 1e-9)) + 1):
        now_ns = tick * CYCLE_NS // 4
        odometry = told(wheels, odometry, SPEED * now_ns * 1e-9 - way)
        way = SPEED * now_ns * 1e-9
        tracker.move(odometry)
        for n in range(tick % 4, len(RING), 4):
            tracker.explains(heard(RING[n], odometry, scenes[n](now_ns), now_ns))
        truth = true_pose(way)
        off.append(hypot(tracker.pose.x - truth.x, tracker.pose.y - truth.y))
        lost = lost or tracker.is_lost
    return Went(sum(off) / len(off), max(off), lost, truth)


def heard(ranger: Ranger, robot: Pose, echoes: tuple, now_ns: int) -> PlacedPing:
    """The first echo that is loud enough, and not too near."""
    loud = [echo.distance for echo in echoes if echo.margin >= 0.0 and echo.distance >= ranger.nearest]
    reading = RangeReading(now_ns, 0, ranger.name, Outcome.ECHO, loud[0]) if loud else None
    reading = reading or RangeReading(now_ns, 0, ranger.name, Outcome.NO_ECHO, 0.0)
    return PlacedPing(reading, ranger, robot.compose(ranger.mount))


def _tuple(pose: Pose) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.yaw
