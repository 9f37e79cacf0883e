from dataclasses import replace
from math import atan2, cos, hypot, inf, pi, radians, sin

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from echogrid.emulation.crosstalk import Earshot, Mouth
from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.reflections import echoes
from echogrid.emulation.reflectors import Station
from echogrid.emulation.transducers import POLAROID, SRF08
from echogrid.emulation.walker import Walker
from echogrid.emulation.world import World
from echogrid.emulation.worlds import WORLDS

EVERYTHING = 1000.0
"""dB: so faint is nothing here."""
OFFICE = office()
TOUR = office_tour()
tour_times = st.floats(0.0, TOUR.lap_time)
bearings = st.floats(-pi, pi)


def world_of(walls=(), cylinders=(), rough=(), softness=None):
    flags = np.array([index in rough for index in range(len(walls))], dtype=bool)
    return World(
        "test",
        np.array(walls).reshape(-1, 4),
        flags,
        np.array(cylinders).reshape(-1, 3),
        wall_softness=None if softness is None else np.array(softness),
    )


def mouth(x, y, yaw, transducer=SRF08):
    return Mouth(Station.at((x, y, yaw)), transducer)


def ways(world, source, listener, faintest=EVERYTHING):
    """The open ways, shortest first."""
    earshot = Earshot(world.at(0.0), listener, faintest)
    return sorted(way for way in earshot.ways_from(source) if earshot.is_open(source, way))


def facing(here, there):
    return mouth(*here, atan2(there[1] - here[1], there[0] - here[0]))


def test_two_that_face_each_other_hear_each_other_straight():
    ((length, loss, turn),) = ways(world_of(), mouth(0.0, 0.0, 0.0), mouth(3.0, 4.0, pi + atan2(4.0, 3.0)))
    assert length == pytest.approx(5.0)
    assert turn is None
    assert loss == pytest.approx(17.3718 * (atan2(4.0, 3.0) / SRF08.null_angle) ** 2, rel=1e-5)


def test_who_looks_away_neither_hears_nor_is_heard():
    away, towards = mouth(0.0, 0.0, pi), mouth(2.0, 0.0, pi)
    assert ways(world_of(), away, towards) == []
    assert ways(world_of(), towards, away) == []


def test_a_wall_in_between_keeps_the_sound_off():
    world = world_of(((1.0, -9.0, 1.0, 9.0),))
    around = ways(world, mouth(0.0, 0.0, 0.0), mouth(2.0, 0.0, pi))
    assert {way.turn for way in around} == {(1.0, -9.0), (1.0, 9.0)}


places = st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0))


@settings(deadline=None)
@given(places, places, st.floats(-pi, pi), st.floats(0.5, 4.0))
def test_a_mirror_s_way_is_as_long_as_that_to_the_image(here, there, normal, offset):
    """The wall is long, and far enough for both to be on one side of it."""
    nx, ny = cos(normal), sin(normal)
    offset += max(nx * x + ny * y for x, y in (here, there))
    foot, along = np.array((offset * nx, offset * ny)), np.array((-ny, nx))
    world = world_of(((*(foot - 90.0 * along), *(foot + 90.0 * along)),))
    height = offset - (nx * here[0] + ny * here[1])
    image = here[0] + 2.0 * height * nx, here[1] + 2.0 * height * ny
    source = mouth(*here, normal)
    listener = mouth(*there, normal)
    lengths = [way.length for way in ways(world, source, listener) if way.turn and hypot(*way.turn) < 50.0]
    assert lengths == pytest.approx([hypot(image[0] - there[0], image[1] - there[1])])


@settings(deadline=None)
@given(places, places, st.floats(0.05, 0.4))
def test_the_way_over_a_post_is_the_shortest_over_its_surface(here, there, radius):
    assume(hypot(*here) > radius + 0.2 and hypot(*there) > radius + 0.2)
    world = world_of(cylinders=((0.0, 0.0, radius),))
    found = ways(world, facing(here, (0.0, 0.0)), facing(there, (0.0, 0.0)))
    around = np.linspace(-pi, pi, 40_001)
    xs, ys = radius * np.cos(around), radius * np.sin(around)
    lit = np.hypot(xs - here[0], ys - here[1]) + np.hypot(xs - there[0], ys - there[1])
    over = [way.length for way in found if way.turn is not None]
    assert over == [] or over == [pytest.approx(lit.min(), abs=1e-5)]
    across = abs(here[0] * there[1] - here[1] * there[0]) / max(hypot(*np.subtract(here, there)), 1e-9)
    if across > radius + 0.01:
        assert len(over) == 1


@settings(deadline=None, max_examples=60)
@given(tour_times, bearings, bearings, st.floats(-1.0, 1.0), st.sampled_from(["office", "home", "foyer"]))
def test_swapped_transducers_have_the_same_ways_and_losses(share, first, second, apart, name):
    venue = WORLDS[name]()
    x, y, _ = venue.tour.pose(share)
    here, there = mouth(x, y, first), mouth(x + 0.3 * apart, y + 0.2 * apart, second, POLAROID)
    assume(venue.world.surface_distance(np.array([here.station[:2], there.station[:2]])).min() > 0.05)
    forth, back = ways(venue.world, here, there), ways(venue.world, there, here)
    assert [way.length for way in forth] == pytest.approx([way.length for way in back])
    assert [way.loss for way in forth] == pytest.approx([way.loss for way in back], abs=1e-3)


@settings(deadline=None, max_examples=60)
@given(tour_times, bearings)
def test_at_one_place_the_ways_are_those_of_the_echoes(t_s, bearing):
    x, y, _ = TOUR.pose(t_s)
    sharp = replace(SRF08, sensitivity=60.0, reach=5.0, ramp_end=0.001)
    heard = [
        (echo.distance, sharp.sensitivity - echo.margin)
        for echo in echoes(OFFICE, (x, y, bearing), sharp)
        if echo.kind in ("wall", "corner", "edge", "cylinder")
    ]
    here = mouth(x, y, bearing, sharp)
    found = [
        (0.5 * way.length, way.loss + sharp.way_loss(0.5 * way.length)) for way in ways(OFFICE, here, here)
    ]
    for distance, loss in heard:
        assert any(
            distance == pytest.approx(half_way, abs=1e-5) and loss == pytest.approx(lost, abs=1e-3)
            for half_way, lost in found
        )


@settings(deadline=None, max_examples=40)
@given(tour_times, bearings, bearings)
def test_nothing_that_is_loud_enough_is_overlooked(t_s, first, second):
    """Looking closely only at what may be heard finds all that is heard."""
    x, y, _ = TOUR.pose(t_s)
    source, listener = mouth(x, y, first), mouth(x + 0.1, y + 0.1, second)

    def loud(faintest):
        return [
            way
            for way in ways(OFFICE, source, listener, faintest)
            if way.loss + SRF08.way_loss(0.5 * way.length) <= 40.0
        ]

    assert loud(40.0) == loud(EVERYTHING)


def test_a_soft_mirror_takes_its_part():
    wall = ((2.0, -9.0, 2.0, 9.0),)
    source, listener = mouth(0.0, -0.2, 0.0), mouth(0.0, 0.2, 0.0)
    hard, *_ = ways(world_of(wall), source, listener)
    soft, *_ = ways(world_of(wall, softness=(12.0,)), source, listener)
    assert soft.loss - hard.loss == pytest.approx(12.0)
    assert soft.length == hard.length


def test_a_rough_wall_scatters_towards_who_is_not_in_its_mirror():
    wall = ((2.0, -0.5, 2.0, 0.5),)
    source, listener = mouth(0.0, 0.0, 0.0), mouth(0.5, 3.0, -radians(60.0))
    smooth = ways(world_of(wall), source, listener)
    assert {way.turn for way in smooth if way.turn} == {(2.0, -0.5), (2.0, 0.5)}
    rough = ways(world_of(wall, rough={0}), source, listener)
    facets = [way for way in rough if way.turn and abs(way.turn[1]) < 0.49]
    assert len(facets) == 10
    for length, loss, (x, y) in facets:
        assert x == pytest.approx(2.0)
        assert length == pytest.approx(hypot(2.0, y) + hypot(1.5, 3.0 - y))
        assert 14.0 < loss < inf


def test_a_corner_sends_the_sound_back_by_its_vertex():
    corner = ((2.0, -1.0, 2.0, 1.0), (2.0, 1.0, 0.0, 1.0))
    found = ways(world_of(corner), mouth(0.5, 0.0, 0.6), mouth(0.4, 0.1, 0.6))
    vertex = [way for way in found if way.turn == (2.0, 1.0)]
    assert [way.length for way in vertex] == pytest.approx([hypot(1.5, 1.0) + hypot(1.6, 0.9)])
    assert vertex[0].loss < 1.0


def test_a_person_stands_in_the_way():
    world = replace(world_of(), walkers=(Walker(((1.5, -3.0), (1.5, 3.0)), start=3.0),))
    source, listener = mouth(0.0, 0.0, 0.0), mouth(3.0, 0.0, pi)
    assert ways(world, source, listener) == []
    later = Earshot(world.at(3.0), listener, EVERYTHING)
    assert [later.is_open(source, way) for way in later.ways_from(source) if way.turn is None] == [True]
