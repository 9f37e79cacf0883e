"""Walls on trial: a room by hand, and one ranger in it."""

from math import inf, isnan, nan, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.wall_faces import WallFaces, faces_of
from echogrid.mapping.wall_trials import Ping, View, echoes_of, trials, tried

GEOMETRY = GridGeometry.covering(-1.0, -3.0, 4.0, 3.0, 0.1)
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.05, 4.0)


def walls(*boxes: tuple[float, float, float, float]) -> WallFaces:
    """The faces of boxes from x0, y0 to x1, y1."""
    x, y = np.meshgrid(GEOMETRY.x_centres, GEOMETRY.y_centres)
    occupied = np.zeros(GEOMETRY.shape, np.bool_)
    for x0, y0, x1, y1 in boxes:
        occupied |= (x > x0) & (x < x1) & (y > y0) & (y < y1)
    return faces_of(GEOMETRY, occupied)


AHEAD = walls((2.0, -2.0, 2.2, 2.0))
"""One wall 2 m ahead; the centre of its cells is 5 cm behind its face."""


@settings(deadline=None, max_examples=30)
@given(st.floats(-45.0, 45.0))
def test_a_wall_ahead_is_on_trial_at_the_foot_of_its_perpendicular(yaw_deg: float) -> None:
    (view,) = tried(AHEAD, SONAR, Pose(0.0, 0.05, radians(yaw_deg)), nan)
    assert view.bearing == pytest.approx(radians(-yaw_deg), abs=radians(1.0))
    assert view.distance == pytest.approx(2.05, abs=0.01)


def test_an_echo_of_its_distance_is_heard_a_longer_one_or_none_is_not() -> None:
    readings = (2.05, 2.6, nan)
    views = [tried(AHEAD, SONAR, Pose(0.0, 0.05), reading)[0] for reading in readings]
    made = trials([Ping(0, number, 0, reading) for number, reading in enumerate(readings)], views)
    assert made.on_trial.tolist() == [True, True, True]
    assert made.heard.tolist() == [True, False, False]
    assert np.all(made.first)


def test_a_wall_behind_a_nearer_sound_is_not_decided() -> None:
    views = tried(AHEAD, SONAR, Pose(0.0, 0.05), 1.0)
    made = trials([Ping(0, 0, 0, 1.0)] * len(views), views)
    assert not made.on_trial.any()


def test_a_wall_that_is_hidden_is_on_no_trial() -> None:
    faces = walls((2.0, -2.0, 2.2, 2.0), (1.0, -0.1, 1.1, 0.2))
    assert all(isnan(view.bearing) for view in tried(faces, SONAR, Pose(0.0, 0.05), nan))


def test_a_wall_is_on_no_trial_beside_something_that_is_as_far_away() -> None:
    faces = walls((2.0, -2.0, 2.2, 2.0), (1.5, 1.2, 1.6, 1.3))
    assert all(isnan(view.bearing) for view in tried(faces, SONAR, Pose(0.0, 0.05), nan))


def test_of_two_walls_both_are_on_trial() -> None:
    faces = walls((2.0, -3.0, 2.2, 3.0), (-1.0, 1.2, 0.8, 1.4))
    views = tried(faces, SONAR, Pose(0.0, 0.05, radians(45.0)), nan)
    assert sorted(round(view.bearing, 1) for view in views) == [-0.8, 0.8]
    made = trials([Ping(0, 7, 0, nan)] * 2, views)
    assert made.first.tolist() == [True, False]


def test_pings_that_look_alike_count_as_one_view_together() -> None:
    views = [View(inf, 0.3, 2.0, 0.1)] * 5 + [View(inf, 0.1, 2.0, 0.1)]
    made = trials([Ping(0, number, 3, nan) for number in range(6)], views)
    assert made.weight.tolist() == pytest.approx([0.2] * 5 + [1.0])


def test_what_agrees_with_an_echo_is_told_even_where_no_wall_is_on_trial() -> None:
    (view,) = tried(AHEAD, SONAR, Pose(0.0, 0.05), 2.05)
    assert view.agreeing == pytest.approx(0.0, abs=radians(3.0))
    (view,) = tried(AHEAD, SONAR, Pose(0.0, 0.05), 0.5)
    assert view.agreeing == inf
    assert isnan(tried(walls(), SONAR, Pose(), nan)[0].agreeing)


def test_an_echo_is_put_down_to_the_wall_that_is_as_far_away() -> None:
    (echo,) = echoes_of(AHEAD, SONAR, Pose(0.0, 0.05), 2.0)
    assert AHEAD.cells[echo.face] == pytest.approx((2.05, 0.05), abs=0.06)
    assert echoes_of(AHEAD, SONAR, Pose(0.0, 0.05), 1.0) == []
