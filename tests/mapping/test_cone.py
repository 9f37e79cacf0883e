from math import pi, radians

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.cone import belief, cast
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger, effective_tolerance
from echogrid.mapping.sounding import Sounding

from .strategies import poses, rangers

SURE = 1e-7
"""Cells nearer than this to a border of the cone may count on either side of it."""

echoes = st.none() | st.floats(0.0, 6.0)
resolutions = st.floats(0.05, 0.5)


def cells_by_definition(
    geometry: GridGeometry, seat: Pose, ranger: Ranger, reach: float, margin: float
) -> set[tuple[int, int]]:
    """Every cell of the grid in the cone, or in the strip of half a cell around its axis, up to `reach`."""
    dx = geometry.x_centres[np.newaxis, :] - seat.x
    dy = geometry.y_centres[:, np.newaxis] - seat.y
    bearing = np.arctan2(dy, dx) - seat.yaw
    distance = np.hypot(dx, dy)
    along, across = distance * np.cos(bearing), distance * np.abs(np.sin(bearing))
    in_cone = across * np.cos(ranger.half_angle) <= along * np.sin(ranger.half_angle) + margin
    in_strip = across <= geometry.resolution / 2.0 + margin
    inside = (along > -margin) & (in_cone | in_strip) & (distance <= reach + margin)
    return set(zip(*(index.tolist() for index in np.nonzero(inside)), strict=True))


@settings(deadline=None)
@given(poses(8.0), rangers(), echoes, resolutions, st.floats(0.0, 0.5))
def test_no_cell_of_the_cone_is_missed_and_none_outside_is_taken(
    seat: Pose, ranger: Ranger, echo: float | None, resolution: float, tolerance: float
) -> None:
    geometry = GridGeometry.covering(-6.0, -6.0, 6.0, 6.0, resolution)
    cone = cast(geometry, Sounding(seat, ranger, echo, tolerance))
    reach = ranger.farthest
    if echo is not None:
        reach = echo + effective_tolerance(tolerance, resolution, echo)
    cells = set(zip(cone.rows.tolist(), cone.cols.tolist(), strict=True))
    assert len(cells) == len(cone.rows)
    assert cells_by_definition(geometry, seat, ranger, reach, -SURE) <= cells
    assert cells <= cells_by_definition(geometry, seat, ranger, reach, SURE)


@settings(deadline=None)
@given(poses(8.0), rangers(), echoes, resolutions)
def test_the_patch_holds_all_cells_of_the_cone(
    seat: Pose, ranger: Ranger, echo: float | None, resolution: float
) -> None:
    geometry = GridGeometry.covering(-6.0, -6.0, 6.0, 6.0, resolution)
    cone = cast(geometry, Sounding(seat, ranger, echo, 0.1))
    rows, cols = cone.patch
    assert np.all((cone.rows >= rows.start) & (cone.rows < rows.stop))
    assert np.all((cone.cols >= cols.start) & (cone.cols < cols.stop))


@settings(deadline=None)
@given(poses(8.0), rangers(), echoes)
def test_every_number_of_a_cone_is_finite_and_in_its_range(
    seat: Pose, ranger: Ranger, echo: float | None
) -> None:
    cone = cast(GridGeometry.covering(-6.0, -6.0, 6.0, 6.0, 0.2), Sounding(seat, ranger, echo, 0.1))
    assert np.all((cone.belief >= 0.0) & (cone.belief <= 1.0))
    assert np.all((cone.bearing >= 0.0) & (cone.bearing <= pi / 2.0))
    assert np.all(np.isfinite(cone.distance))


@settings(deadline=None)
@given(poses(3.0), rangers(), st.floats(0.3, 4.0))
def test_a_ray_along_the_axis_meets_a_cell_where_the_echo_came_from(
    seat: Pose, ranger: Ranger, echo: float
) -> None:
    cone = cast(GridGeometry.covering(-9.0, -9.0, 9.0, 9.0, 0.1), Sounding(seat, ranger, echo, 0.0))
    assert cone.occupied.any()


@given(poses(), rangers())
def test_where_nothing_came_back_nothing_is_taken_for_an_obstacle(seat: Pose, ranger: Ranger) -> None:
    cone = cast(GridGeometry.covering(-6.0, -6.0, 6.0, 6.0, 0.2), Sounding(seat, ranger, None, 0.1))
    assert not cone.echo
    assert not cone.occupied.any()


def test_a_narrow_cone_has_no_holes_in_front_of_the_transducer() -> None:
    needle = Ranger("needle", Pose(), radians(1.0), 0.0, 4.0)
    cone = cast(GridGeometry(0.1, 0.0, -1.0, 20, 40), Sounding(Pose(0.0, 0.03, 0.0), needle, 3.0, 0.1))
    assert set(cone.cols.tolist()) == set(range(31))


def test_the_belief_is_one_at_the_transducer_and_none_at_the_far_edge() -> None:
    edge = belief(np.array([0.0, 10.0]), np.radians([0.0, 15.0]), 10.0, radians(15.0))
    assert edge == approx([1.0, 0.0], abs=1e-12)


@given(st.floats(0, 20), st.floats(0, pi))
def test_the_belief_falls_with_distance_and_off_the_axis(distance: float, bearing: float) -> None:
    r, a = np.array([distance, distance + 0.5, distance]), np.array([bearing, bearing, bearing + 0.1])
    here, farther, wider = belief(r, a, 10.0, radians(15.0))
    assert here >= farther
    assert here >= wider
