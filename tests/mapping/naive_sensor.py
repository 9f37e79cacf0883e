"""The obstacle sensor written down as it is meant, cell by cell: a twin to be equal to and quicker than."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import atan2, cos, floor, hypot, inf, pi, sin, sqrt, tau

import numpy as np

from echogrid.mapping.footprint import Footprint
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.twist import Twist

Point = tuple[float, float]
OCCUPIED = 850


@dataclass(frozen=True)
class NaiveSector:
    nearest: float
    known: float
    seen: float


def cells(local: LocalGrid, robot: Pose, horizon: float) -> Iterator[tuple[int, int, float, float]]:
    """Row, column and centre in base_link of each cell that is within the horizon of the middle one."""
    geometry = local.geometry
    middle = geometry.rows // 2
    for row in range(geometry.rows):
        for col in range(geometry.cols):
            if hypot(row - middle, col - middle) * geometry.resolution <= horizon:
                dx = geometry.x + (col + 0.5) * geometry.resolution - robot.x
                dy = geometry.y + (row + 0.5) * geometry.resolution - robot.y
                c, s = cos(robot.yaw), sin(robot.yaw)
                yield row, col, c * dx + s * dy, c * dy - s * dx


def sectors(local: LocalGrid, robot: Pose, now_ns: int, count: int, horizon: float) -> list[NaiveSector]:
    """Of each direction: the nearest obstacle, and the parts of it that were spoken of ever, and in the last
    second. Cells belong to the sector in which their offset from the middle cell points."""
    total, known, seen, nearest = [0] * count, [0] * count, [0] * count, [inf] * count
    middle = local.geometry.rows // 2
    for row, col, x, y in cells(local, robot, horizon):
        if row == col == middle:
            continue  # the robot's own
        bearing = atan2(row - middle, col - middle) - robot.yaw
        k = floor(bearing * count / tau + 0.5) % count
        stamp_ns = int(local.seen_ns[row, col])
        total[k] += 1
        known[k] += stamp_ns > 0
        seen[k] += stamp_ns > now_ns - 1_000_000_000
        if local.grid.log_odds[row, col] >= OCCUPIED:
            nearest[k] = min(nearest[k], hypot(x, y))
    return [NaiveSector(nearest[k], known[k] / total[k], seen[k] / total[k]) for k in range(count)]


def clearance(outline: Footprint, point: Point) -> float:
    """m from a point to the outline; 0 within."""
    sides = list(zip(outline.corners, (*outline.corners[1:], outline.corners[0]), strict=True))
    turned, away = 0.0, inf
    for a, b in sides:
        ax, ay, bx, by = a[0] - point[0], a[1] - point[1], b[0] - point[0], b[1] - point[1]
        turned += atan2(ax * by - ay * bx, ax * bx + ay * by)
        along = ((-ax) * (bx - ax) + (-ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)
        part = min(max(along, 0.0), 1.0)
        away = min(away, hypot(ax + part * (bx - ax), ay + part * (by - ay)))
    return 0.0 if abs(turned) > pi else away


def seen_from(twist: Twist, time: float, point: Point) -> Point:
    """Where a point of the world is in base_link when the twist has lasted so long."""
    turn = twist.turn_rate * time
    chord = twist.speed * time * float(np.sinc(turn / tau))
    dx, dy = point[0] - chord * cos(turn / 2.0), point[1] - chord * sin(turn / 2.0)
    return cos(turn) * dx + sin(turn) * dy, cos(turn) * dy - sin(turn) * dx


def seconds(
    local: LocalGrid, robot: Pose, outline: Footprint, twist: Twist, times: list[float], slack: float = 0.0
) -> float:
    """The first of those times at which the footprint is within `slack` (m) of the disc around an obstacle's
    cell."""
    radius = local.geometry.resolution * sqrt(0.5)
    horizon = (local.geometry.rows // 2 - 1) * local.geometry.resolution
    found = inf
    for row, col, x, y in cells(local, robot, horizon):
        if local.grid.log_odds[row, col] < OCCUPIED:
            continue
        start = clearance(outline, (x, y))
        if start <= 1e-6:
            continue
        near = min(radius, start - 1e-6)
        touched = (
            time for time in times if clearance(outline, seen_from(twist, time, (x, y))) <= near + slack
        )
        found = min(found, next(touched, inf))
    return found
