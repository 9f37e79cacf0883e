from math import nan

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.grid import GridGeometry

geometries = st.builds(
    GridGeometry,
    st.floats(0.01, 2.0),
    st.floats(-100, 100),
    st.floats(-100, 100),
    st.integers(1, 60),
    st.integers(1, 60),
)
points = st.floats(-200, 200)


@given(geometries, st.data())
def test_a_cell_covers_its_own_centre(geometry: GridGeometry, data: st.DataObject) -> None:
    row = data.draw(st.integers(0, geometry.rows - 1))
    col = data.draw(st.integers(0, geometry.cols - 1))
    assert geometry.cell(geometry.x_centres[col], geometry.y_centres[row]) == (row, col)
    assert geometry.contains(row, col)


@given(geometries, points, points)
def test_a_point_is_within_half_a_cell_of_its_cell_s_centre(
    geometry: GridGeometry, x: float, y: float
) -> None:
    row, col = geometry.cell(x, y)
    half = geometry.resolution / 2.0
    assert abs(geometry.x + (col + 0.5) * geometry.resolution - x) <= half + 1e-9
    assert abs(geometry.y + (row + 0.5) * geometry.resolution - y) <= half + 1e-9


def test_row_0_is_the_southernmost_and_column_0_the_westernmost() -> None:
    geometry = GridGeometry(0.5, -1.0, 2.0, 4, 3)
    assert list(geometry.x_centres) == [-0.75, -0.25, 0.25]
    assert list(geometry.y_centres) == [2.25, 2.75, 3.25, 3.75]
    assert geometry.shape == (4, 3)


def test_cells_outside_are_not_contained() -> None:
    geometry = GridGeometry(1.0, 0.0, 0.0, 2, 3)
    outside = [(-1, 0), (2, 0), (0, -1), (0, 3)]
    assert not any(geometry.contains(*cell) for cell in outside)


@given(points, points, st.floats(0, 50), st.floats(0, 50), st.floats(0.05, 2.0))
def test_a_grid_over_a_box_covers_it_and_little_more(
    west: float, south: float, width: float, height: float, resolution: float
) -> None:
    east, north = west + width, south + height
    geometry = GridGeometry.covering(west, south, east, north, resolution)
    right = geometry.x + geometry.cols * resolution
    top = geometry.y + geometry.rows * resolution
    assert geometry.x <= west + 1e-9
    assert geometry.y <= south + 1e-9
    assert right >= east - 1e-9
    assert top >= north - 1e-9
    assert right - geometry.x <= width + 2.0 * resolution + 1e-9
    assert top - geometry.y <= height + 2.0 * resolution + 1e-9


@given(points, points, st.floats(0.05, 2.0))
def test_borders_of_cells_lie_on_multiples_of_the_resolution(
    west: float, south: float, resolution: float
) -> None:
    geometry = GridGeometry.covering(west, south, west + 3.0, south + 3.0, resolution)
    assert geometry.x / resolution == approx(round(geometry.x / resolution), abs=1e-6)
    assert geometry.y / resolution == approx(round(geometry.y / resolution), abs=1e-6)


@given(geometries, points, points, st.floats(0, 100), st.floats(0, 100))
def test_the_window_over_a_box_holds_every_cell_whose_centre_is_in_it(
    geometry: GridGeometry, west: float, south: float, width: float, height: float
) -> None:
    rows, cols = geometry.window(west, south, west + width, south + height)
    in_x = (geometry.x_centres >= west) & (geometry.x_centres <= west + width)
    in_y = (geometry.y_centres >= south) & (geometry.y_centres <= south + height)
    assert in_x.sum() == in_x[cols].sum()
    assert in_y.sum() == in_y[rows].sum()


def test_the_window_over_a_box_outside_is_empty() -> None:
    geometry = GridGeometry(1.0, 0.0, 0.0, 5, 5)
    for box in [(-9.0, 1.0, -7.0, 2.0), (9.0, 1.0, 11.0, 2.0), (1.0, -9.0, 2.0, -7.0), (1.0, 9.0, 2.0, 11.0)]:
        rows, cols = geometry.window(*box)
        assert min(rows.stop - rows.start, cols.stop - cols.start) == 0


@pytest.mark.parametrize(
    ("resolution", "rows", "cols"), [(0.0, 1, 1), (-0.1, 1, 1), (nan, 1, 1), (0.1, 0, 1), (0.1, 1, 0)]
)
def test_a_grid_without_cells_is_refused(resolution: float, rows: int, cols: int) -> None:
    with pytest.raises(ValueError, match="positive resolution"):
        GridGeometry(resolution, 0.0, 0.0, rows, cols)
