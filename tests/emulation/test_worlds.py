import json
from dataclasses import astuple
from hashlib import sha256

import numpy as np
import pytest

from echogrid.emulation import acoustics, detector
from echogrid.emulation.transducers import POLAROID, TRANSDUCERS
from echogrid.emulation.worlds import WORLDS

NAMES = sorted(WORLDS)
CLEAR = 0.3
"""m, from the robot's middle to any surface."""

FROZEN_WORLDS = {
    "clutter": "45cc645a31d2cef6",
    "corridor": "b2ce0c56f7331977",
    "foyer": "b4ebafa22fa072ef",
    "home": "8ac3f222deadc98d",
    "museum": "ae30ddfae84537e3",
    "office": "1e0041ec7e7107af",
    "warehouse": "4d56732cb3bdd4ab",
    "workshop": "ad76748525a68e63",
}
FROZEN_PARAMETERS = "2b3ab489cb7c8b1b"
FROZEN_POLAROID = "54de673d"
FROZEN_TRANSDUCERS = {
    "srf01": "b263819e",
    "srf02": "b263819e",
    "srf02-serial": "b263819e",
    "srf08": "4d612eae",
    "srf10": "6b28d8c9",
    "srf235": "43da447f",
    "i2cxl": "10f93aed",
    "maxbotix": "5adfa759",
    "urm07": "955573b1",
    "urm09": "0950d8d8",
    "urm12": "2d52a03f",
    "urm13": "0db04148",
    "urm13-i2c": "0db04148",
    "urm14": "1b0215a4",
    "urm15": "a37aa1f9",
    "urm37": "80d44981",
    "rcwl-9620": "e686ccc5",
    "a02yyuw": "ad1c1a4b",
    "dyp-rs485": "ad1c1a4b",
    "ff-on-demand": "ad1c1a4b",
    "ping": "7a51f489",
    "iio": "c84d3c18",
}


def _times(tour, step):
    return np.arange(0.0, tour.lap_time, step)


def _path(tour, step):
    return np.array([tour.pose(t_s)[:2] for t_s in _times(tour, step)])


def test_there_are_enough_worlds():
    assert {"office", "corridor", "clutter", "warehouse", "home", "foyer"} < set(WORLDS)
    assert len(WORLDS) >= 8


@pytest.mark.parametrize("name", NAMES)
def test_a_world_has_the_name_by_which_it_is_found(name):
    assert WORLDS[name]().world.name == name


@pytest.mark.parametrize("name", NAMES)
def test_the_tour_is_long_and_keeps_clear_of_everything(name):
    world, tour = WORLDS[name]()
    assert tour.lap_length >= 60.0
    assert world.surface_distance(_path(tour, 0.05)).min() >= CLEAR


@pytest.mark.parametrize("name", NAMES)
def test_nobody_walks_into_the_robot_or_a_wall(name):
    """However long it runs: who crosses the tour at all is round a whole number of times in a lap."""
    world, tour = WORLDS[name]()
    path = _path(tour, 0.1)
    for walker in world.walkers:
        assert 0.75 <= walker.speed <= 0.85
        assert 0.2 <= walker.radius <= 0.25
        assert 10.0 <= walker.softness <= 15.0
        round_s = walker.lap_length / walker.speed
        way = np.array([walker.at(t_s)[:2] for t_s in np.arange(0.0, round_s, 0.05)])
        assert world.surface_distance(way).min() > walker.radius
        in_step = tour.lap_time / round_s
        if in_step == pytest.approx(round(in_step), abs=1e-9):
            met = np.array([walker.at(t_s)[:2] for t_s in _times(tour, 0.1)])
            apart = np.hypot(*(met - path).T).min()
        else:
            apart = min(np.hypot(*(path - place).T).min() for place in way)
        assert apart - walker.radius >= CLEAR


def test_people_cross_the_way_of_the_robot_in_the_foyer():
    world, tour = WORLDS["foyer"]()
    path = _path(tour, 0.5)
    ways = [np.array([walker.at(t_s)[:2] for t_s in np.arange(0.0, 40.0, 0.2)]) for walker in world.walkers]
    crossed = [min(np.hypot(*(path - place).T).min() for place in way) < 0.3 for way in ways]
    assert sum(crossed) >= 3


@pytest.mark.parametrize("name", NAMES)
def test_walls_meet_at_their_ends_and_do_not_cross(name):
    walls = WORLDS[name]().world.walls
    starts, spans = walls[:, :2], walls[:, 2:] - walls[:, :2]
    for start, span in zip(starts, spans, strict=True):
        offset = starts - start
        across = span[0] * spans[:, 1] - span[1] * spans[:, 0]
        slanted = np.abs(across) > 1e-9
        divisor = np.where(slanted, across, 1.0)
        here = (offset[:, 0] * spans[:, 1] - offset[:, 1] * spans[:, 0]) / divisor
        there = (offset[:, 0] * span[1] - offset[:, 1] * span[0]) / divisor
        inside = slanted & (here > 1e-6) & (here < 1.0 - 1e-6) & (there > 1e-6) & (there < 1.0 - 1e-6)
        assert not inside.any()


@pytest.mark.parametrize("name", NAMES)
def test_no_post_stands_in_another(name):
    posts = WORLDS[name]().world.cylinders
    for index, (x, y, radius) in enumerate(posts):
        others = np.delete(posts, index, axis=0)
        gaps = np.hypot(others[:, 0] - x, others[:, 1] - y) - others[:, 2] - radius
        assert gaps.min(initial=np.inf) > 0.0


def test_a_home_is_soft_and_a_foyer_has_people():
    home, foyer = WORLDS["home"]().world, WORLDS["foyer"]().world
    assert home.lengths[home.softness >= 10.0].sum() > 10.0
    assert len(foyer.walkers) == 6


def _rounded(value):
    """Numbers to nine places, so that every machine has the same."""
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in sorted(value.items())}
    if isinstance(value, np.ndarray | list | tuple | frozenset):
        return [_rounded(each) for each in (sorted(value) if isinstance(value, frozenset) else value)]
    return round(float(value), 9) + 0.0


def _digest(numbers):
    return sha256(json.dumps(_rounded(numbers), sort_keys=True).encode()).hexdigest()[:16]


def _numbers(name):
    world, tour = WORLDS[name]()
    return {
        "walls": world.walls,
        "rough": world.rough,
        "softness": world.softness,
        "cylinders": world.cylinders,
        "soft cylinders": [] if world.cylinder_softness is None else world.cylinder_softness,
        "temperature": world.temperature,
        "walkers": [(w.waypoints, w.start, w.speed, w.radius, w.softness) for w in world.walkers],
        "tour": (tour.waypoints, tour.spins, astuple(tour.limits)),
    }


@pytest.mark.parametrize("name", NAMES)
def test_the_worlds_are_frozen(name):
    """Whoever changes one on purpose re-runs every baseline, and puts the new digest here."""
    assert _digest(_numbers(name)) == FROZEN_WORLDS[name]


def test_the_acoustic_parameters_are_frozen():
    """The same holds for them."""
    losses = (acoustics.EDGE_LOSS, acoustics.ROUGH_LOSS, acoustics.BOUNCE_LOSS)
    spreading = (acoustics.PLANE_SPREADING, acoustics.EDGE_SPREADING, acoustics.POINT_SPREADING)
    level = (detector.LEVEL_NOISE, detector.DROPOUT)
    timing = (detector.RANGE_NOISE, detector.RANGE_NOISE_RATIO, detector.LATE_AT_THRESHOLD)
    assert _digest((losses, spreading, level, timing)) == FROZEN_PARAMETERS


@pytest.mark.parametrize("model", TRANSDUCERS)
def test_the_transducers_are_frozen(model):
    """And for these; a new model brings its digest along."""
    assert _digest(astuple(TRANSDUCERS[model]))[:8] == FROZEN_TRANSDUCERS[model]


def test_the_sonar_of_the_acoustics_check_is_frozen():
    assert _digest(astuple(POLAROID))[:8] == FROZEN_POLAROID
