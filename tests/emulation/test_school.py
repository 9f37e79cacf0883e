from itertools import pairwise
from math import hypot

import numpy as np
from pytest import approx, fixture, mark

from echogrid.emulation.worlds import WORLDS, Venue
from echogrid.emulation.worlds.school import LEAST_M, school

SEEDS = (0, 1, 2)
"""A hall, a floor of rooms, a hall with people."""


@fixture(scope="module")
def venues() -> list[Venue]:
    return [school(seed) for seed in SEEDS]


def test_the_kinds_take_turns(venues: list[Venue]) -> None:
    assert [venue.world.name for venue in venues] == ["hall", "rooms", "crowd"]
    assert [bool(venue.world.walkers) for venue in venues] == [False, False, True]


def test_a_round_is_long_enough_and_clear_of_everything(venues: list[Venue]) -> None:
    for world, tour in venues:
        assert tour.lap_length >= LEAST_M
        places = np.array([tour.pose(t)[:2] for t in np.arange(0.0, tour.lap_time, 0.5)])
        assert world.surface_distance(places).min() > 0.35


def test_neighbouring_way_points_differ(venues: list[Venue]) -> None:
    for _, tour in venues:
        for (ax, ay), (bx, by) in pairwise([*tour.waypoints, tour.waypoints[0]]):
            assert hypot(bx - ax, by - ay) > 0.1


@mark.parametrize("seed", SEEDS[:1])
def test_a_seed_always_makes_the_same_world(seed: int, venues: list[Venue]) -> None:
    again = school(seed)
    assert np.array_equal(again.world.walls, venues[seed].world.walls)
    assert again.tour.pose(50.0) == approx(venues[seed].tour.pose(50.0), abs=0.0)


def test_none_of_them_is_a_world_that_is_judged_in() -> None:
    assert not {"hall", "rooms", "crowd"} & set(WORLDS)
