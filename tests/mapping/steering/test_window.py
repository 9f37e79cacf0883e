from math import atan2, hypot, pi, tau

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.steering.window import Body, Window

from .scenes import BODY, CELLS, RESOLUTION, WINDOW


def test_the_window_holds_each_cell_within_its_horizon_once_the_nearest_first() -> None:
    rows, cols = WINDOW.flat // CELLS - CELLS // 2, WINDOW.flat % CELLS - CELLS // 2
    found = list(zip(rows.tolist(), cols.tolist(), strict=True))
    reach = range(-CELLS // 2, CELLS // 2)
    expected = {(row, col) for row in reach for col in reach if hypot(row, col) <= 16.0}
    assert set(found) == expected
    assert len(found) == len(expected)
    assert found[0] == (0, 0)
    assert np.all(np.diff(WINDOW.distance) >= 0.0)
    assert WINDOW.bearing[1:].tolist() == approx([atan2(row, col) for row, col in found[1:]], abs=1e-12)


@given(st.integers(3, 130), st.sampled_from([0.05, 0.1, 0.2]), st.floats(0.2, 9.0))
def test_a_window_stays_within_its_grid(cells: int, resolution: float, horizon: float) -> None:
    window = Window(resolution, cells, BODY, horizon)
    assert window.flat.min() >= 0
    assert window.flat.max() < cells**2
    assert window.horizon <= horizon + 1e-9
    assert 2 * window.half + 1 <= cells


@given(st.floats(0.0, 3.0))
def test_cells_are_counted_by_distance(distance: float) -> None:
    assert WINDOW.within(distance) == int((WINDOW.distance <= distance).sum())


@given(st.floats(0.1, 0.5), st.floats(0.0, 0.3), st.sampled_from([8, 36, 72, 180]))
def test_a_cell_blocks_the_sectors_in_which_the_robot_would_come_too_near(
    radius: float, margin: float, sectors: int
) -> None:
    """Straight from the middle; sectors wider than the obstacle are blocked by the nearest."""
    window = Window(RESOLUTION, 30, Body(radius, margin), 1.2, sectors)
    for index in range(1, len(window.flat), 7):
        x, y = window.x[index], window.y[index]
        blocked = {k % sectors for k in range(window.first[index], window.last[index] + 1)}
        for k in range(sectors):
            ahead = (k * tau / sectors - atan2(y, x) + pi) % tau - pi
            off = hypot(x, y) * abs(np.sin(ahead))
            if abs(ahead) < pi / 2.0 - 1e-6 and off < window.keep - 1e-6:
                assert k in blocked
            if (abs(ahead) > pi / 2.0 + 1e-6 or off > window.keep + 1e-6) and abs(ahead) > pi / sectors:
                assert k not in blocked


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(0.0, tau))
def test_the_robot_and_its_margin_are_within_what_is_kept_free_wherever_in_its_cell_it_is(
    x: float, y: float, angle: float
) -> None:
    reach = BODY.radius + BODY.margin
    rim = x * RESOLUTION + reach * np.cos(angle), y * RESOLUTION + reach * np.sin(angle)
    assert hypot(*rim) <= WINDOW.keep + 1e-9


@pytest.mark.parametrize(("horizon", "sectors"), [(0.05, 72), (1.0, 4), (1.0, 71)])
def test_a_window_without_room_or_with_odd_sectors_is_refused(horizon: float, sectors: int) -> None:
    with pytest.raises(ValueError, match="a window needs"):
        Window(RESOLUTION, CELLS, BODY, horizon, sectors)


@pytest.mark.parametrize(("radius", "margin"), [(0.0, 0.1), (0.2, -0.1), (float("nan"), 0.1)])
def test_a_robot_without_a_size_is_refused(radius: float, margin: float) -> None:
    with pytest.raises(ValueError, match="radius above 0"):
        Body(radius, margin)
