"""What a glimpse leaves out is never missed: all that is heard is the same, to the bit."""

from math import pi

import numpy as np
import pytest

from echogrid.emulation.ear import ear
from echogrid.emulation.hearing import Outing, Ranger, scene_of
from echogrid.emulation.transducers import POLAROID, TRANSDUCERS
from echogrid.emulation.world import World
from echogrid.emulation.worlds.arenas import ARENAS

ROUND_NS = 140_000_000
PINGS = 60


def heard(world, pose_at, transducer, seed):
    scene = scene_of(Outing(world, pose_at, seed), Ranger("ranger", (0.1, -0.05, 0.3), transducer))
    return [scene(number * ROUND_NS) for number in range(PINGS)]


@pytest.mark.parametrize("name", ARENAS)
@pytest.mark.parametrize("transducer", [POLAROID, TRANSDUCERS["srf08"], TRANSDUCERS["maxbotix"]])
def test_it_changes_nothing_that_is_heard(monkeypatch, name, transducer):
    arena = ARENAS[name]()
    rng = np.random.default_rng(len(name))
    places = arena.inside + rng.uniform(-1.2, 1.2, (PINGS + 1, 2))
    yaws = rng.uniform(-2.0 * pi, 2.0 * pi, PINGS + 1)

    def pose_at(now_ns):
        index = min(now_ns // ROUND_NS, PINGS)
        drift = 5e-10 * (now_ns - index * ROUND_NS)
        return places[index, 0] + drift, places[index, 1], yaws[index] + drift

    told = [heard(arena.world, pose_at, transducer, seed) for seed in (None, 3)]
    assert sum(map(bool, told[1])) > PINGS // 10
    monkeypatch.setattr(World, "glimpse_at", lambda world, x, y, yaw, ear: world.vista_at(x, y))
    assert told == [heard(arena.world, pose_at, transducer, seed) for seed in (None, 3)]


def test_much_is_left_out():
    world = ARENAS["office"]().world
    keen = ear(POLAROID, POLAROID.sensitivity)
    whole, part = world.vista_at(7.2, 5.0), world.glimpse_at(7.2, 5.0, 0.1, keen)
    assert len(part.barriers) < len(whole.barriers) / 2
    assert len(part.smooth) < len(whole.smooth) / 2
    assert set(part.edges) < set(whole.edges)
