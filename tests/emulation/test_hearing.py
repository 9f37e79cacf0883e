from dataclasses import replace
from math import pi

import numpy as np
import pytest

from echogrid.emulation.acoustics import speed_of_sound
from echogrid.emulation.hearing import Outing, Ranger, mounted, scene_of
from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.transducers import POLAROID
from echogrid.emulation.walker import Walker
from echogrid.emulation.world import World

WALL = World("wall", np.array([(4.0, -9.0, 4.0, 9.0)]), np.array([False]), np.empty((0, 3)))
FRONT = Ranger("front", (0.2, 0.0, 0.0), POLAROID)


def still(_ns):
    return (0.0, 0.0, 0.0)


def test_a_mount_moves_with_the_robot():
    assert mounted((1.0, 2.0, pi / 2), (0.3, 0.1, pi / 4)) == pytest.approx((0.9, 2.3, 3 * pi / 4))


def test_a_standing_robot_hears_from_where_its_ranger_is():
    (echo,) = scene_of(Outing(WALL, still, None), FRONT)(0)
    assert echo.distance == pytest.approx(3.8)


def test_a_moving_robot_hears_from_where_it_is_when_the_sound_meets_the_wall():
    speed = 10.0
    scene = scene_of(Outing(WALL, lambda ns: (speed * 1e-9 * ns, 0.0, 0.0), None), FRONT)
    outward_s = 3.8 / speed_of_sound(20.0)
    assert scene(0)[0].distance == pytest.approx(3.8 - speed * outward_s, abs=1e-6)


def test_in_cold_air_the_sound_takes_longer():
    cold = World("cold", WALL.walls, WALL.rough, WALL.cylinders, temperature=-30.0)
    scene = scene_of(Outing(cold, lambda ns: (10e-9 * ns, 0.0, 0.0), None), FRONT)
    outward_s = 3.8 / speed_of_sound(-30.0)
    assert scene(0)[0].distance == pytest.approx(3.8 - 10.0 * outward_s, abs=1e-6)


PASSER_BY = Walker(((2.0, -6.0), (2.0, 6.0)), speed=1.0, radius=0.25, softness=10.0)
LOUD = Ranger("front", (0.0, 0.0, 0.0), replace(POLAROID, sensitivity=50.0))


def test_a_person_in_the_way_hides_the_wall_and_moves_the_echo():
    """Six seconds after the start they are right in front."""
    start_ns = 7_000_000_000
    outing = Outing(replace(WALL, walkers=(PASSER_BY,)), still, None, start_ns)
    scene = scene_of(outing, LOUD)
    assert [(echo.kind, echo.distance) for echo in scene(start_ns)] == [("wall", pytest.approx(4.0))]
    met = scene(start_ns + 6_000_000_000)
    assert [(echo.kind, echo.distance) for echo in met] == [("cylinder", pytest.approx(1.75))]


def test_a_dressed_person_returns_less_than_a_bare_post():
    bare = replace(WALL, walkers=(replace(PASSER_BY, softness=0.0),))
    dressed = replace(WALL, walkers=(PASSER_BY,))
    levels = [
        scene_of(Outing(world, still, None), LOUD)(6_000_000_000)[0].margin for world in (bare, dressed)
    ]
    assert levels[0] - levels[1] == pytest.approx(10.0)


def _heard(name, seed):
    tour = office_tour()
    outing = Outing(office(), lambda ns: tour.pose(1e-9 * ns), seed)
    scene = scene_of(outing, Ranger(name, (0.2, 0.0, 0.0), POLAROID))
    return [scene(int(1e9 * t_s)) for t_s in range(40)]


def test_the_same_seed_gives_the_same_echoes():
    assert _heard("front", 7) == _heard("front", 7)


def test_another_seed_or_another_ranger_gives_other_noise():
    assert _heard("front", 7) != _heard("front", 8)
    assert _heard("front", 7) != _heard("rear", 7)
