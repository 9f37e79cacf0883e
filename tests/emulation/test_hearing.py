from math import pi

import numpy as np
import pytest

from echogrid.emulation.acoustics import POLAROID, speed_of_sound
from echogrid.emulation.hearing import Ranger, mounted, scene_of
from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.world import World

WALL = World("wall", np.array([(4.0, -9.0, 4.0, 9.0)]), np.array([False]), np.empty((0, 3)))
FRONT = Ranger("front", (0.2, 0.0, 0.0), POLAROID)


def still(_ns):
    return (0.0, 0.0, 0.0)


def test_a_mount_moves_with_the_robot():
    assert mounted((1.0, 2.0, pi / 2), (0.3, 0.1, pi / 4)) == pytest.approx((0.9, 2.3, 3 * pi / 4))


def test_a_standing_robot_hears_from_where_its_ranger_is():
    (echo,) = scene_of(WALL, still, FRONT, None)(0)
    assert echo.distance == pytest.approx(3.8)


def test_a_moving_robot_hears_from_where_it_is_when_the_sound_meets_the_wall():
    speed = 10.0
    scene = scene_of(WALL, lambda ns: (speed * 1e-9 * ns, 0.0, 0.0), FRONT, None)
    outward_s = 3.8 / speed_of_sound(20.0)
    assert scene(0)[0].distance == pytest.approx(3.8 - speed * outward_s, abs=1e-6)


def test_in_cold_air_the_sound_takes_longer():
    cold = World("cold", WALL.walls, WALL.rough, WALL.cylinders, temperature=-30.0)
    scene = scene_of(cold, lambda ns: (10e-9 * ns, 0.0, 0.0), FRONT, None)
    outward_s = 3.8 / speed_of_sound(-30.0)
    assert scene(0)[0].distance == pytest.approx(3.8 - 10.0 * outward_s, abs=1e-6)


def _heard(name, seed):
    tour = office_tour()
    scene = scene_of(office(), lambda ns: tour.pose(1e-9 * ns), Ranger(name, (0.2, 0.0, 0.0), POLAROID), seed)
    return [scene(int(1e9 * t_s)) for t_s in range(40)]


def test_the_same_seed_gives_the_same_echoes():
    assert _heard("front", 7) == _heard("front", 7)


def test_another_seed_or_another_ranger_gives_other_noise():
    assert _heard("front", 7) != _heard("front", 8)
    assert _heard("front", 7) != _heard("rear", 7)
