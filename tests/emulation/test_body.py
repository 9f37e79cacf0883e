"""How far things are from an outline, against points laid out along both."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.emulation.body import Disc, Hull
from echogrid.emulation.vista import Post
from echogrid.emulation.world import World

HULL = Hull(((0.3, -0.2), (0.3, 0.2), (-0.1, 0.25), (-0.2, 0.0), (-0.1, -0.25)))
DENSE = np.linspace(0.0, 1.0, 400)
STEP = 0.01
"""m: how coarsely points are laid out, at most."""

places = st.floats(-1.5, 1.5)
walls = st.tuples(places, places, places, places).filter(
    lambda wall: np.hypot(wall[2] - wall[0], wall[3] - wall[1]) > 0.05
)
poses = st.tuples(places, places, st.floats(-pi, pi))


def world_of(wall, *posts):
    return World("bare", np.array([wall]), np.zeros(1, np.bool_), np.array(posts).reshape(-1, 3))


def along(start, end):
    return np.add(start, DENSE[:, np.newaxis] * np.subtract(end, start))


def outline(pose):
    x, y, yaw = pose
    corners = np.array(HULL.corners) @ np.array(((cos(yaw), sin(yaw)), (-sin(yaw), cos(yaw)))) + (x, y)
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return np.concatenate([along(*side) for side in sides]), corners


def within(corners, points):
    spans = np.roll(corners, -1, axis=0) - corners
    off = points[:, np.newaxis] - corners
    return (spans[:, 0] * off[..., 1] - spans[:, 1] * off[..., 0] >= 0.0).all(axis=1)


def apart(points, others):
    return np.hypot(*(points[:, np.newaxis] - others).T).min()


@given(poses, walls)
def test_a_wall_is_as_far_from_a_polygon_as_its_points_are(pose, wall):
    around, corners = outline(pose)
    points = along(wall[:2], wall[2:])
    gap = HULL.gaps(pose, world_of(wall), ()).walls[0]
    if within(corners, points).any():
        assert gap == 0.0
    else:
        assert gap == pytest.approx(apart(around, points), abs=STEP)


@given(poses, places, places, st.floats(0.02, 0.3))
def test_a_post_is_as_far_from_a_polygon_as_its_middle_less_its_radius(pose, x, y, radius):
    around, corners = outline(pose)
    middle = np.array([(x, y)])
    gap = HULL.gaps(pose, world_of((5.0, 5.0, 6.0, 6.0)), [Post(x, y, radius, 0.0)]).posts[0]
    signed = apart(around, middle) * (-1.0 if within(corners, middle)[0] else 1.0)
    assert gap == pytest.approx(signed - radius, abs=STEP)


@given(poses, walls)
def test_a_disc_is_as_far_as_its_middle_less_its_radius(pose, wall):
    gap = Disc(0.2).gaps(pose, world_of(wall), ()).walls[0]
    assert gap == pytest.approx(apart(along(wall[:2], wall[2:]), np.array([pose[:2]])) - 0.2, abs=STEP)


def test_people_come_after_what_stands():
    gaps = Disc(0.2).gaps(
        (0.0, 0.0, 0.0), world_of((5.0, 5.0, 6.0, 6.0), (1.0, 0.0, 0.1)), [Post(0, 2, 0.3, 0)]
    )
    assert gaps.posts == pytest.approx([0.7, 1.5])
    assert gaps.least == pytest.approx(0.7)


def test_the_fastest_corner_of_a_polygon_tells_its_speed():
    square = Hull(((0.3, -0.4), (0.3, 0.4), (-0.3, 0.4), (-0.3, -0.4)))
    assert square.speed(0.0, 2.0) == pytest.approx(1.0)
    assert square.speed(0.5, 0.0) == pytest.approx(0.5)
    assert Disc(0.3).speed(-0.4, 2.0) == 0.4
