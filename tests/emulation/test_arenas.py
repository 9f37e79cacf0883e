"""The worlds to be driven through: well built, and passable for a robot."""

import numpy as np
import pytest

from echogrid.emulation.shortest_path import Floor
from echogrid.emulation.worlds import WORLDS
from echogrid.emulation.worlds.arenas import ARENAS

NEW = sorted(set(ARENAS) - set(WORLDS))
WIDE = 0.27
"""m: the robot's radius, and 5 cm."""


def test_the_frozen_worlds_are_among_them():
    assert set(WORLDS) < set(ARENAS)
    assert len(NEW) == 6


@pytest.mark.parametrize("name", NEW)
def test_every_start_leads_to_every_goal(name):
    arena = ARENAS[name]()
    floor = Floor.of(arena.world, WIDE)
    lengths, _ = floor.lengths_from(floor.cell(arena.inside))
    for x0, y0, x1, y1 in (*arena.starts, *arena.goals):
        rows, cols = zip(floor.cell((x0, y0)), floor.cell((x1, y1)), strict=True)
        part = np.s_[rows[0] : rows[1] + 1, cols[0] : cols[1] + 1]
        assert np.isfinite(lengths[part]).any()


@pytest.mark.parametrize("name", NEW)
def test_people_walk_at_0_8_mps_through_nothing_that_stands(name):
    world = ARENAS[name]().world
    for walker in world.walkers:
        assert walker.speed == 0.8
        way = np.array([walker.at(t_s)[:2] for t_s in np.arange(0.0, walker.lap_length / 0.8, 0.05)])
        assert world.surface_distance(way).min() > walker.radius


def test_somebody_crosses_the_passage_and_legs_are_thin():
    assert len(ARENAS["passers-by"]().world.walkers) >= 5
    assert ARENAS["legs"]().world.cylinders[:, 2].max() <= 0.03
    assert not ARENAS["mirrors"]().world.rough.any()


@pytest.mark.parametrize("name", NEW)
def test_no_walls_cross(name):
    walls = ARENAS[name]().world.walls
    starts, spans = walls[:, :2], walls[:, 2:] - walls[:, :2]
    for start, span in zip(starts, spans, strict=True):
        offset = starts - start
        across = span[0] * spans[:, 1] - span[1] * spans[:, 0]
        divisor = np.where(np.abs(across) > 1e-9, across, np.inf)
        here = (offset[:, 0] * spans[:, 1] - offset[:, 1] * spans[:, 0]) / divisor
        there = (offset[:, 0] * span[1] - offset[:, 1] * span[0]) / divisor
        assert not ((here > 1e-6) & (here < 1 - 1e-6) & (there > 1e-6) & (there < 1 - 1e-6)).any()
