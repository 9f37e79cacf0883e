"""What is near is looked up by squares; nothing that is near is missed."""

from math import hypot, pi

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx
from tests.mapping.strategies import poses

from echogrid.mapping.planning.floor_plan import FloorPlan, Points, placed
from echogrid.mapping.pose import Pose

NONE: Points = np.empty((0, 2))
places = st.tuples(st.floats(-8.0, 8.0), st.floats(-8.0, 8.0))
reaches = st.floats(0.0, 6.0)
points = st.lists(places, max_size=30).map(lambda taken: np.array(taken).reshape(-1, 2))


@given(points, st.lists(st.tuples(places, reaches), min_size=1, max_size=5))
def test_all_that_is_near_is_found_whatever_was_asked_before(
    walls: Points, asked: list[tuple[tuple[float, float], float]]
) -> None:
    plan = FloorPlan(walls, NONE)
    for (x, y), reach in asked:
        found = {tuple(point) for point in plan.near(x, y, reach).tolist()}
        away = {(a, b): hypot(a - x, b - y) for a, b in walls.tolist()}
        assert {point for point, far in away.items() if far <= reach} <= found
        assert found <= {point for point, far in away.items() if far <= reach + 1.5}


def test_a_plan_without_walls_has_nothing_near() -> None:
    assert FloorPlan(NONE, NONE).near(3.0, -2.0, 5.0).shape == (0, 2)


def test_points_are_turned_and_then_moved_into_the_frame() -> None:
    there = placed(np.array([(1.0, 0.0), (0.0, 2.0)]), Pose(10.0, 20.0, pi / 2.0))
    assert there == approx(np.array([(10.0, 21.0), (8.0, 20.0)]))


@given(points, poses())
def test_points_are_placed_as_poses_are_composed_and_come_back_by_the_inverse(
    taken: Points, frame: Pose
) -> None:
    there = placed(taken, frame)
    for (x, y), (to_x, to_y) in zip(taken.tolist(), there.tolist(), strict=True):
        moved = frame.compose(Pose(x, y))
        assert (to_x, to_y) == approx((moved.x, moved.y), abs=1e-9)
    assert placed(there, frame.inverse()) == approx(taken, abs=1e-9)
