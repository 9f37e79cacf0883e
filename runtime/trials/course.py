"""Where a robot starts, where it is sent, and how long the shortest way there is."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, hypot, pi
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.floor_plan import Rectangle
from echogrid.emulation.reflectors import Pose
from echogrid.emulation.shortest_path import Cell, Floor, traced
from echogrid.emulation.vista import Point
from echogrid.emulation.world import World
from echogrid.emulation.worlds.arena import Arena
from echogrid.emulation.worlds.arenas import ARENAS
from echogrid.mapping.planning.floor_plan import SPACING, FloorPlan, Points, placed
from echogrid.mapping.pose import Pose as Frame

GOAL_M = 0.4
"""From the goal: within it the robot, as far as it knows its place, is there."""
MARGIN_M = 0.05
"""What the shortest way keeps between the robot and all things."""
_SHORTEST_M, _LONGEST_M = 6.0, 25.0
"""Where any place may be the goal."""
_FROM_PEOPLE_M = 1.0
"""At the start."""


@dataclass(frozen=True, slots=True)
class Course:
    """A task."""

    arena: Arena
    start: Pose
    goal: Point
    shortest: float
    """m: of the shortest way that comes within GOAL_M of the goal."""
    begins_s: float
    """The world's own time at the start: people are somewhere on their ways."""

    def floor_plan(self, reach: float, furnished: bool) -> FloorPlan:
        """What an architect draws, walls and floor, and if it is `furnished` posts and legs, too; no people.

        As seen from the start; of the floor, where a robot can be that reaches `reach` (m) from its middle.
        """
        world = self.arena.world
        stands = [_dotted(world.walls), *(_rim(*post) for post in world.cylinders.tolist() if furnished)]
        floor = _floor(world, reach + MARGIN_M)
        free = [floor.middle((int(row), int(col))) for row, col in np.argwhere(floor.free)]
        back = Frame(*self.start).inverse()
        return FloorPlan(placed(np.concatenate(stands), back), placed(np.array(free), back))


def _dotted(walls: NDArray[np.float64]) -> Points:
    """Points on walls (n, 4), from end to end."""
    parts = []
    for x0, y0, x1, y1 in walls.tolist():
        count = ceil(hypot(x1 - x0, y1 - y0) / SPACING) + 1
        parts.append(np.column_stack((np.linspace(x0, x1, count), np.linspace(y0, y1, count))))
    return np.concatenate(parts)


def _rim(x: float, y: float, radius: float) -> Points:
    """Points around a post."""
    angles = np.arange(max(ceil(2.0 * pi * radius / SPACING), 8)) * 2.0 * pi
    angles /= len(angles)
    return np.column_stack((x + radius * np.cos(angles), y + radius * np.sin(angles)))


@lru_cache(maxsize=32)
def arena_of(world: str) -> Arena:
    """The world of that name; what is found out about it is kept for the next drive."""
    return ARENAS[world]()


@lru_cache(maxsize=32)
def _floor(world: World, radius: float) -> Floor:
    return Floor.of(world, radius)


@lru_cache(maxsize=32)
def _plan(world: str, radius: float) -> tuple[Floor, NDArray[np.bool_]]:
    """The floor, and which of it can be reached from its inside."""
    arena = arena_of(world)
    floor = _floor(arena.world, radius)
    lengths, _ = floor.lengths_from(floor.cell(arena.inside))
    return floor, np.isfinite(lengths)


def course(world: str, seed: int, reach: float) -> Course:
    """The task of a seed, for a robot of which nothing is farther than `reach` (m) from its middle."""
    arena = arena_of(world)
    floor, reachable = _plan(world, reach + MARGIN_M)
    rng = np.random.default_rng((seed, crc32(world.encode())))
    begins_s = float(rng.uniform(0.0, 60.0))
    people = [walker.at(begins_s) for walker in arena.world.walkers]
    starts = [
        cell
        for cell in _cells(floor, reachable, arena.starts)
        if all(
            _apart(floor.middle(cell), (person.x, person.y)) > _FROM_PEOPLE_M + person.radius
            for person in people
        )
    ]
    start = starts[int(rng.integers(len(starts)))]
    lengths, before = floor.lengths_from(start)
    far_enough = np.isfinite(lengths)
    if not arena.goals:
        far_enough = (lengths >= _SHORTEST_M) & (lengths <= _LONGEST_M)
    goals = list(_cells(floor, far_enough, arena.goals))
    goal = goals[int(rng.integers(len(goals)))]
    shortest = floor.tight([floor.middle(cell) for cell in traced(before, goal)]) - GOAL_M
    yaw = float(rng.uniform(-pi, pi))
    return Course(arena, (*floor.middle(start), yaw), floor.middle(goal), shortest, begins_s)


def _cells(floor: Floor, chosen: NDArray[np.bool_], where: Iterable[Rectangle]) -> list[Cell]:
    """The chosen cells in one of the rectangles; all, if there is none."""
    cells = [(int(row), int(col)) for row, col in np.argwhere(chosen)]
    rectangles = list(where)
    if not rectangles:
        return cells
    return [cell for cell in cells if any(_within(floor.middle(cell), each) for each in rectangles)]


def _within(point: Point, rectangle: Rectangle) -> bool:
    x0, y0, x1, y1 = rectangle
    return x0 <= point[0] <= x1 and y0 <= point[1] <= y1


def _apart(one: Point, other: Point) -> float:
    return hypot(one[0] - other[0], one[1] - other[1])
