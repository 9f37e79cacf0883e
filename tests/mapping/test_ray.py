from math import cos, sin

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ray import cross

from .strategies import poses

GEOMETRY = GridGeometry.covering(-2.0, -2.0, 2.0, 2.0, 0.2)
SURE = 1e-7

lengths = st.floats(0.0, 8.0)


def chord(row: int, col: int, start: Pose, length: float, margin: float) -> float:
    """m: how much of the line lies in a cell that is so much wider on each side (Liang and Barsky)."""
    first, last = 0.0, length
    corner = GEOMETRY.x + col * GEOMETRY.resolution, GEOMETRY.y + row * GEOMETRY.resolution
    for place, step, border in zip((start.x, start.y), (cos(start.yaw), sin(start.yaw)), corner, strict=True):
        low, high = border - margin, border + GEOMETRY.resolution + margin
        if step == 0.0:
            last = last if low < place < high else -1.0
            continue
        ends = sorted(((low - place) / step, (high - place) / step))
        first, last = max(first, ends[0]), min(last, ends[1])
    return max(last - first, 0.0)


@given(poses(3.0), lengths)
def test_the_cells_are_those_of_which_the_line_has_a_piece(start: Pose, length: float) -> None:
    ray = cross(GEOMETRY, start, length)
    found = set(zip(ray.rows.tolist(), ray.cols.tolist(), strict=True))
    assert len(found) == len(ray.rows)
    for row in range(GEOMETRY.rows):
        for col in range(GEOMETRY.cols):
            if chord(row, col, start, length, -SURE) > SURE:
                assert (row, col) in found
            if (row, col) in found:
                assert chord(row, col, start, length, SURE) > 0.0


@given(poses(1.9), st.floats(0.01, 8.0))
def test_each_cell_lies_beside_the_one_before(start: Pose, length: float) -> None:
    ray = cross(GEOMETRY, start, length)
    steps = np.maximum(np.abs(np.diff(ray.rows)), np.abs(np.diff(ray.cols)))
    assert np.all(steps == 1)
    assert (ray.rows[0], ray.cols[0]) == GEOMETRY.cell(
        start.x + 1e-9 * cos(start.yaw), start.y + 1e-9 * sin(start.yaw)
    )


@given(poses(8.0), lengths)
def test_the_patch_holds_all_cells(start: Pose, length: float) -> None:
    ray = cross(GEOMETRY, start, length)
    rows, cols = ray.patch
    assert np.all((ray.rows >= rows.start) & (ray.rows < rows.stop))
    assert np.all((ray.cols >= cols.start) & (ray.cols < cols.stop))


def test_a_line_through_corners_has_the_cells_of_the_diagonal() -> None:
    ray = cross(GridGeometry(1.0, 0.0, 0.0, 4, 4), Pose(0.0, 0.0, np.pi / 4.0), 4.0)
    assert ray.rows.tolist() == ray.cols.tolist() == [0, 1, 2]


def test_a_line_along_the_cells_has_one_in_each_column() -> None:
    ray = cross(GridGeometry(0.1, 0.0, 0.0, 3, 30), Pose(0.05, 0.15, 0.0), 2.0)
    assert ray.cols.tolist() == list(range(21))
    assert set(ray.rows.tolist()) == {1}


def test_a_line_beside_the_grid_has_no_cells() -> None:
    ray = cross(GEOMETRY, Pose(5.0, 5.0, 0.0), 3.0)
    assert not len(ray.rows)
    assert ray.patch == (slice(0, 0), slice(0, 0))
