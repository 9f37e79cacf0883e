"""The floor plan of a course: the world's walls and floor, as seen from the start."""

from math import hypot

import numpy as np
import pytest

from echogrid.mapping.planning.floor_plan import SPACING, placed
from echogrid.mapping.pose import Pose
from echogrid.runtime.trials.course import MARGIN_M, Course, course

REACH = 0.22


@pytest.fixture(scope="module", params=["corridor", "legs", "passers-by"])
def task(request: pytest.FixtureRequest) -> Course:
    return course(request.param, 3, REACH)


def test_the_walls_of_a_plan_are_those_of_the_world_without_a_gap(task: Course) -> None:
    there = placed(task.floor_plan(REACH, False).walls, Pose(*task.start))
    row = 0
    for x0, y0, x1, y1 in task.arena.world.walls.tolist():
        length = hypot(x1 - x0, y1 - y0)
        points = there[row : row + max(int(np.ceil(length / SPACING - 1e-9)), 1) + 1]
        if np.hypot(*(points[-1] - (x1, y1))) > 1e-6:  # rounding may have made it one point more
            points = there[row : row + len(points) + 1]
        row += len(points)
        assert np.hypot(*(points[0] - (x0, y0))) < 1e-6
        assert np.hypot(*(points[-1] - (x1, y1))) < 1e-6
        assert np.hypot(*np.diff(points, axis=0).T).max() <= SPACING + 1e-6
    assert row == len(there)


def test_nothing_but_walls_is_drawn(task: Course) -> None:
    world = task.arena.world
    there = placed(task.floor_plan(REACH, False).walls, Pose(*task.start))
    onto = np.full(len(there), np.inf)
    for start, along, length in zip(world.starts, world.along, world.lengths, strict=True):
        foot = start + np.clip((there - start) @ along, 0.0, length)[:, np.newaxis] * along
        np.minimum(onto, np.hypot(*(there - foot).T), out=onto)
    assert onto.max() < 1e-6


def test_the_free_floor_is_where_the_robot_may_be(task: Course) -> None:
    plan = task.floor_plan(REACH, False)
    there = placed(plan.free, Pose(*task.start))
    assert task.arena.world.surface_distance(there).min() >= REACH + MARGIN_M - 1e-9
    goal = Pose(*task.start).inverse().compose(Pose(*task.goal))
    for x, y in ((0.0, 0.0), (goal.x, goal.y)):
        assert np.hypot(*(plan.free - (x, y)).T).min() < 1e-6


def test_a_furnished_plan_has_the_rims_of_all_posts_besides(task: Course) -> None:
    bare, furnished = (task.floor_plan(REACH, each).walls for each in (False, True))
    assert np.array_equal(furnished[: len(bare)], bare)
    there = placed(furnished[len(bare) :], Pose(*task.start))
    away = [np.abs(np.hypot(*(there - (x, y)).T) - radius) for x, y, radius in task.arena.world.cylinders]
    assert bool(away) == bool(len(there))
    if away:
        assert np.min(away, axis=0).max() < 1e-9
        assert np.min(away, axis=1).max() < 1e-9
