from math import atan2, cos, hypot, radians, remainder, sin, tanh, tau

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.range_layer import LETHAL, NOTHING, RangeLayerGrid, RangeLayerSettings, sensed, trust
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sounding import Sounding

from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-2.0, -2.0, 2.0, 2.0, 0.1)
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.0, 4.0)
pings = st.tuples(poses(2.0), rangers(0.05), st.none() | st.floats(0.01, 4.0))


def says(r: float, alpha: float, echo: float, half_angle: float) -> float:
    """P(Occupied) at a cell, as the layer's description has it."""
    central = 1.0 - (alpha / half_angle) ** 2 if abs(alpha) <= half_angle else 0.0
    trusted = (1.0 - (1.0 + tanh(2.0 * (r - 1.2))) / 2.0) * central
    band = GEOMETRY.resolution * echo
    if r < echo - 2.0 * band:
        return (1.0 - trusted) / 2.0
    if r < echo - band:
        return trusted / 2.0 * ((r - (echo - 2.0 * band)) / band) ** 2 + (1.0 - trusted) / 2.0
    if r < echo + band:
        return trusted * (0.5 - 0.5 * ((echo - r) / band) ** 2) + 0.5
    return 0.5


@settings(deadline=None)
@given(pings)
def test_an_update_is_that_of_the_description_cell_by_cell(ping: tuple[Pose, Ranger, float | None]) -> None:
    seat, ranger, echo = ping
    grid = RangeLayerGrid(GEOMETRY)
    grid.update(Sounding(*ping, 0.1))
    if echo is None:
        assert grid.unknown().all()
        return
    end = GEOMETRY.cell(seat.x + echo * cos(seat.yaw), seat.y + echo * sin(seat.yaw))
    corners = [(seat.x, seat.y), (seat.x + echo * cos(seat.yaw), seat.y + echo * sin(seat.yaw))]
    for side in (-1, 1):
        yaw = seat.yaw + side * ranger.half_angle
        corners.append((seat.x + 1.2 * echo * cos(yaw), seat.y + 1.2 * echo * sin(yaw)))
    box = [GEOMETRY.cell(x, y) for x, y in corners]
    for row, y in enumerate(GEOMETRY.y_centres):
        for col, x in enumerate(GEOMETRY.x_centres):
            prior = (233 if (row, col) == end else 127) / 254
            alpha = remainder(atan2(y - seat.y, x - seat.x) - seat.yaw, tau)
            s = says(hypot(x - seat.x, y - seat.y), alpha, echo, ranger.half_angle)
            rows, cols = [cell[0] for cell in box], [cell[1] for cell in box]
            if not (min(rows) <= row <= max(rows) and min(cols) <= col <= max(cols)):
                s = 0.5
            due = 254 * s * prior / (s * prior + (1 - s) * (1 - prior))
            assert abs(int(grid.bytes[row, col]) - due) <= 1.0 + 1e-6


@settings(deadline=None)
@given(st.lists(pings, max_size=8), st.booleans())
def test_every_number_is_a_probability_and_a_ping_speaks_only_of_its_patch(many, clears: bool) -> None:
    grid = RangeLayerGrid(GEOMETRY, RangeLayerSettings(clear_on_max_reading=clears))
    for ping in many:
        before = grid.bytes.copy()
        patch = grid.update(Sounding(*ping, 0.1))
        changed = grid.bytes != before
        if patch is not None:
            changed[patch] = False
        assert not changed.any()
    occupancy = grid.occupancy()
    assert np.all((occupancy >= 0.0) & (occupancy < 1.0))
    assert np.all(occupancy[grid.unknown()] == 0.5)


@pytest.mark.parametrize(("metres", "due"), [(1.0, 0.69), (2.0, 0.039), (3.0, 0.0007)])
def test_beyond_2_m_it_hardly_trusts_a_ping(metres: float, due: float) -> None:
    found = trust(np.array([metres]), np.array([0.0]), radians(15.0), 1.2)[0]
    assert found == approx(due, rel=0.07)


def test_an_echo_speaks_for_an_obstacle_at_the_band_s_middle_and_against_one_before() -> None:
    before, middle, beyond = sensed(np.array([0.5, 1.0, 1.2]), 1.0, 0.05, np.full(3, 0.6))
    assert (before, middle, beyond) == approx((0.2, 0.8, 0.5))


def test_what_is_0_never_rises_again_but_on_the_axis() -> None:
    grid = RangeLayerGrid(GEOMETRY)
    grid.bytes[:] = 0
    for _ in range(50):
        grid.update(Sounding(Pose(-1.0, 0.05), SONAR, 1.0, 0.1))
    on_axis = GEOMETRY.cell(0.0 + 1e-9, 0.05)
    assert grid.bytes[on_axis] >= 233
    grid.bytes[on_axis] = 0
    assert not grid.bytes.any()


def test_silence_is_dropped_and_told_to_clear_it_clears_what_the_cone_never_met() -> None:
    silence = Sounding(Pose(-1.9, 0.05), Ranger("sonar", Pose(), radians(15.0), 0.0, 2.0), None, 0.1)
    assert RangeLayerGrid(GEOMETRY).update(silence) is None
    grid = RangeLayerGrid(GEOMETRY, RangeLayerSettings(clear_on_max_reading=True))
    grid.update(silence)
    beside = GEOMETRY.cell(-1.85, 0.55)
    assert grid.bytes[beside] == 0
    assert not grid.unknown()[beside]


def test_the_thresholds_mark_and_clear() -> None:
    grid = RangeLayerGrid(GEOMETRY)
    grid.bytes[0, :4] = (203, 204, 50, 49)
    assert grid.costs()[0, :5].tolist() == [NOTHING, LETHAL, NOTHING, 0, NOTHING]


def test_a_reading_of_0_is_no_trouble() -> None:
    grid = RangeLayerGrid(GEOMETRY)
    grid.update(Sounding(Pose(0.05, 0.05), SONAR, 0.0, 0.1))
    assert np.all(grid.occupancy() < 1.0)


def test_a_copy_goes_its_own_way() -> None:
    grid = RangeLayerGrid(GEOMETRY)
    twin = grid.copy()
    twin.update(Sounding(Pose(), SONAR, 1.0, 0.1))
    assert grid.unknown().all()
    assert not twin.unknown().all()
