from dataclasses import replace
from math import radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.notches import find_notches
from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.truth import truth
from echogrid.emulation.walker import Walker

from .ray_fan import nearest_hit, shortest_way

OFFICE = office()
inside = st.tuples(st.floats(0.0, 14.0), st.floats(0.0, 10.0))


@settings(deadline=None)
@given(st.tuples(st.floats(0.5, 13.5), st.floats(4.9, 5.2)), st.floats(-3.1, 3.1))
def test_a_cast_ray_ends_where_a_plain_one_does(place, heading):
    ray = np.array((np.cos(heading), np.sin(heading)))
    distance, _ = OFFICE.cast(np.array(place), ray)
    assert distance == pytest.approx(nearest_hit(OFFICE, place, heading), abs=1e-5)


@settings(deadline=None)
@given(inside, inside)
def test_sight_is_mutual_and_ends_at_the_first_surface(place, target):
    here, there = np.array([place]), np.array([target])
    sees = OFFICE.line_of_sight(here, there)[0]
    assert sees == OFFICE.line_of_sight(there, here)[0]
    length = float(np.hypot(*(there - here)[0]))
    heading = float(np.arctan2(*(there - here)[0][::-1]))
    first = nearest_hit(OFFICE, place, heading)
    if abs(first - length) > 1e-3 and OFFICE.surface_distance(np.array([place, target])).min() > 0.21:
        assert sees == (first > length)


@given(inside)
def test_surface_distance_is_the_shortest_way(place):
    distance = OFFICE.surface_distance(np.array([place]))[0]
    assert distance == pytest.approx(shortest_way(OFFICE, place), abs=1e-9)


def _kinds(*walls, rough=()):
    flags = np.array([index in rough for index in range(len(walls))])
    notches = find_notches(np.array(walls), flags, np.zeros(len(walls)))
    at_origin = np.hypot(*notches.points.T) < 1e-9
    return sorted("corner" if corner else "edge" for corner in notches.corner[at_origin])


def test_two_walls_at_a_right_angle_are_a_corner_on_one_side_and_an_edge_on_the_other():
    assert _kinds((0.0, 0.0, 1.0, 0.0), (0.0, 1.0, 0.0, 0.0)) == ["corner", "edge"]


def test_a_wall_that_ends_on_another_makes_two_corners():
    assert _kinds((-1.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)) == ["corner", "corner"]


def test_a_lone_end_is_an_edge_and_a_straight_joint_is_nothing():
    assert _kinds((0.0, 0.0, 1.0, 0.0)) == ["edge"]
    assert _kinds((0.0, 0.0, 1.0, 0.0), (-1.0, 0.0, 0.0, 0.0)) == []


def test_a_slight_bend_is_neither_corner_nor_edge():
    bend = radians(30.0)
    assert _kinds((0.0, 0.0, 1.0, 0.0), (0.0, 0.0, -np.cos(bend), np.sin(bend))) == []


def test_a_corner_with_a_rough_side_scatters():
    assert _kinds((0.0, 0.0, 1.0, 0.0), (0.0, 1.0, 0.0, 0.0), rough={1}) == ["edge"]


def test_a_corner_takes_what_both_its_sides_do_and_an_edge_what_the_softer_one_does():
    walls = np.array([(0.0, 0.0, 1.0, 0.0), (0.0, 1.0, 0.0, 0.0)])
    notches = find_notches(walls, np.zeros(2, dtype=bool), np.array([12.0, 3.0]))
    at_origin = np.hypot(*notches.points.T) < 1e-9
    taken = dict(zip(notches.corner[at_origin].tolist(), notches.softness[at_origin].tolist(), strict=True))
    assert taken == {True: 15.0, False: 12.0}


def test_a_plan_s_soft_surfaces_are_walls_of_their_own():
    outline = FloorPlan(((0.0, 0.0, 4.0, 3.0),), (), soft=((1.0, 0.0, 2.5, 0.0, 12.0),)).outline()
    soft = outline.softness > 0.0
    assert outline.walls[soft].tolist() == [[1.0, 0.0, 2.5, 0.0]]
    assert outline.softness[soft].tolist() == [12.0]
    assert len(outline.walls) == 6


def test_people_are_seen_but_are_no_part_of_the_map():
    walker = Walker(((5.0, 5.0), (6.0, 5.0)))
    world = replace(OFFICE, walkers=(walker,))
    place = np.array([[5.0, 5.0]])
    assert world.at(0.0).vista_at(2.5, 5.05).posts[-1] == walker.at(0.0)
    assert world.surface_distance(place) == OFFICE.surface_distance(place)


def test_every_time_has_its_own_people():
    walker = Walker(((5.0, 5.0), (6.0, 5.0)))
    world = replace(OFFICE, walkers=(walker,))
    for time_s in (0.0, 0.3, 0.3, 0.0):
        assert world.at(time_s).people == (walker.at(time_s),)


def test_two_rooms_with_a_door_have_one_outline():
    rooms = ((0.0, 0.0, 2.0, 2.0), (2.1, 0.0, 4.0, 2.0), (2.0, 0.5, 2.1, 1.5))
    walls, rough, _ = FloorPlan(rooms, (), ((4.0, 0.0, 4.0, 2.0),)).outline()
    lengths = np.hypot(*(walls[:, 2:] - walls[:, :2]).T)
    assert len(walls) == 12
    assert lengths.sum() == pytest.approx(2 * (2.0 + 2.0) + 2 * (1.9 + 2.0) - 2 * 1.0 + 2 * 0.1)
    assert lengths[rough].sum() == pytest.approx(2.0)


def _raster(cell):
    return np.arange(-0.5, 14.5, cell) + 0.5 * cell, np.arange(-0.5, 10.5, cell) + 0.5 * cell


@pytest.mark.parametrize("cell", [0.05, 0.1])
def test_the_truth_is_tight_and_holds_the_whole_tour(cell):
    xs, ys = _raster(cell)
    occupied, free = truth(OFFICE, xs, ys, (2.5, 5.05))
    tour = office_tour()
    path = np.array([tour.pose(t_s)[:2] for t_s in np.arange(0.0, tour.lap_time, 0.5)])
    columns, rows = np.floor((path + 0.5) / cell).astype(int).T
    assert occupied.shape == free.shape == (len(ys), len(xs))
    assert free[rows, columns].all()
    assert not (occupied & free).any()
    assert not free[0].any() and not free[:, 0].any()


def test_a_closed_room_keeps_the_flood_in():
    walls = np.array([(1.0, 1.0, 3.0, 1.2), (3.0, 1.2, 2.7, 3.0), (2.7, 3.0, 1.0, 1.0)])
    world = replace(OFFICE, walls=walls, rough=np.zeros(3, dtype=bool), cylinders=np.empty((0, 3)))
    xs = np.arange(0.025, 4.0, 0.05)
    _, free = truth(world, xs, xs, (2.5, 1.7))
    assert 0.5 < free.sum() * 0.05**2 < 1.8
    assert not free[0].any()
