from math import cos, hypot, pi, sin

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from echogrid.mapping.planning.cell_map import CellMap
from echogrid.mapping.planning.floor_plan import SPACING, Points
from echogrid.mapping.pose import Pose

SHAPES = st.tuples(st.integers(1, 8), st.integers(1, 8))
RESOLUTIONS = st.sampled_from([0.02, 0.05, 0.0500000007, 0.1, 0.15, 0.25])
ORIGINS = st.builds(Pose, st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.floats(-pi, pi))
MASKS = SHAPES.flatmap(lambda shape: arrays(np.bool_, shape))


def middle(known: CellMap, row: float, col: float) -> tuple[float, float]:
    point = known.origin.compose(Pose((col + 0.5) * known.resolution, (row + 0.5) * known.resolution))
    return point.x, point.y


def apart(points: Points, place: tuple[float, float]) -> float:
    """m to the nearest of them."""
    return float(np.hypot(*(points - place).T).min())


@given(MASKS, RESOLUTIONS, ORIGINS)
def test_a_point_lies_in_the_cell_of_its_map_whatever_its_origin_and_yaw(mask, resolution, origin) -> None:
    known = CellMap(resolution, origin, mask, ~mask)
    for row, col in np.ndindex(*mask.shape):
        assert known.cell(*middle(known, row, col)) == (row, col)
    rows, cols = mask.shape
    for row, col in ((-1, 0), (rows, 0), (0, -1), (0, cols)):
        assert known.cell(*middle(known, row, col)) is None


@given(MASKS, RESOLUTIONS, ORIGINS)
def test_free_points_are_in_free_cells_and_walls_on_occupied_ones(mask, resolution, origin) -> None:
    known = CellMap(resolution, origin, mask, ~mask)
    plan = known.floor_plan()
    assert all(known.free[known.cell(x, y)] for x, y in plan.free.tolist())
    for x, y in plan.walls.tolist():
        # Across a corner where two cells touch, a wall may lie on the border of four.
        near = [known.cell(x + dx, y + dy) for dx in (-1e-6, 1e-6) for dy in (-1e-6, 1e-6)]
        assert any(cell is not None and known.occupied[cell] for cell in near)


@given(MASKS, RESOLUTIONS, ORIGINS)
def test_each_free_cell_has_points_as_close_as_a_planner_needs(mask, resolution, origin) -> None:
    known = CellMap(resolution, origin, ~mask, mask)
    plan = known.floor_plan()
    for row, col in np.argwhere(mask).tolist():
        corner = middle(known, row - 0.499, col + 0.499)
        assert apart(plan.free, corner) <= max(SPACING, resolution) * hypot(0.5, 0.5) + 1e-6


@given(st.integers(2, 12), RESOLUTIONS, ORIGINS, st.sampled_from([(0, 1), (1, 0), (1, 1), (1, -1)]))
def test_along_a_wall_no_point_is_farther_than_5_cm_from_the_next(length, resolution, origin, step) -> None:
    mask = np.zeros((length + 2, 2 * length + 2), np.bool_)
    cells = [(1 + k * step[0], length + k * step[1]) for k in range(length)]
    for cell in cells:
        mask[cell] = True
    known = CellMap(resolution, origin, mask, ~mask)
    walls = known.floor_plan().walls
    along = sorted(hypot(x - walls[0, 0], y - walls[0, 1]) for x, y in walls.tolist())
    assert np.diff(along).max() <= SPACING + 1e-6
    first, last = (middle(known, *cells[end]) for end in (0, -1))
    assert apart(walls, first) < 1e-9
    assert apart(walls, last) < 1e-9


def test_what_no_cell_but_occupied_ones_borders_on_is_no_wall() -> None:
    solid = np.zeros((7, 7), np.bool_)
    solid[1:6, 1:6] = True
    walls = CellMap(0.05, Pose(), solid, ~solid).floor_plan().walls
    assert len(walls) == 16
    assert apart(walls, (0.175, 0.175)) > 0.09


def test_a_wall_at_the_end_of_the_map_stands() -> None:
    solid = np.ones((1, 3), np.bool_)
    assert len(CellMap(0.05, Pose(), solid, ~solid).floor_plan().walls) == 3


def test_unknown_cells_are_neither_wall_nor_free() -> None:
    nothing = np.zeros((4, 4), np.bool_)
    plan = CellMap(0.05, Pose(), nothing, nothing).floor_plan()
    assert (len(plan.walls), len(plan.free)) == (0, 0)


def test_the_origin_s_yaw_turns_the_map_about_its_lower_left_corner() -> None:
    mask = np.array([[False, True]])
    (wall,) = CellMap(1.0, Pose(2.0, 3.0, pi / 6.0), mask, ~mask).floor_plan().walls[:1].tolist()
    turned = 2.0 + 1.5 * cos(pi / 6.0) - 0.5 * sin(pi / 6.0), 3.0 + 1.5 * sin(pi / 6.0) + 0.5 * cos(pi / 6.0)
    assert np.allclose(wall, turned)
