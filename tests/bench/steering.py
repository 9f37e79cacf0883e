"""What steering costs: all of it, and VFH+'s histogram beside twins that reckon the equations each time."""

from collections.abc import Callable, Iterator
from itertools import repeat
from math import asin, atan2, hypot, pi, sqrt, tau

import numpy as np
from tests.bench.stopwatch import Row, least_us

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.steering.goal import towards
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.obstacles import Obstacles, View
from echogrid.mapping.steering.pace import Pace
from echogrid.mapping.steering.vff import Vff
from echogrid.mapping.steering.vfh import Vfh
from echogrid.mapping.steering.vfh_plus import VfhPlus
from echogrid.mapping.steering.window import Body, Window

RESOLUTION = 0.05
CELLS = 100
NOW = 1_000_000_000
LEAST = 6
SECTORS = 72
TURNS = 200
ROBOT = Pose(0.02, 0.01, 0.3)
SPEED = 0.3


def rows() -> Iterator[Row]:
    """What is measured."""
    local, window = office_corner(), Window(RESOLUTION, CELLS, Body(), 2.45)
    obstacles, limits = Obstacles(window), Limits()
    plus, vfh, vff, pace = VfhPlus(window, limits), Vfh(window), Vff(), Pace(limits)
    goal = towards(ROBOT, 3.0, 0.5)
    view = obstacles.view(local, ROBOT, NOW)
    density = plus.steer(view, SPEED, goal).polar.density
    assert np.array_equal(by_arrays(local, view), density)
    assert np.array_equal(by_loops(local, view), density)
    whole = f"a decision and twist by VFH+ from a grid of {CELLS} x {CELLS}, {len(view.hits)} cells occupied"

    def decide() -> None:
        seen = obstacles.view(local, ROBOT, NOW)
        pace.wish(seen, plus.steer(seen, SPEED, goal))

    each = each_us(decide)
    yield Row(
        whole,
        each,
        "its histogram alone, the equations on arrays each time",
        each_us(lambda: by_arrays(local, view)),
    )
    yield Row(whole, each, "its histogram alone, cell by cell", each_us(lambda: by_loops(local, view), 1))
    yield Row("of which the view of the grid", each_us(lambda: obstacles.view(local, ROBOT, NOW)))
    yield Row("of which VFH+", each_us(lambda: plus.steer(view, SPEED, goal)))
    yield Row("VFH in its place", each_us(lambda: vfh.steer(view, SPEED, goal)))
    yield Row("VFF in its place", each_us(lambda: vff.steer(view, SPEED, goal)))


def each_us(work: Callable[[], object], turns: int = TURNS) -> float:
    """Microseconds of one turn."""

    def many() -> int:
        for _ in repeat(None, turns):
            work()
        return turns

    return least_us(many)


def office_corner() -> LocalGrid:
    """Walls on two sides with noisy certainties, a table leg, and a door that is ajar."""
    local = LocalGrid(RESOLUTION, CELLS, 0.1, 15.0, NoEcho.WEAK)
    local.centre(ROBOT)
    x, y = local.geometry.x_centres[np.newaxis, :], local.geometry.y_centres[:, np.newaxis]
    walls = (np.abs(y - 1.2) < 0.1) | (np.abs(x + 1.5) < 0.1) | (np.hypot(x - 1.0, y + 0.6) < 0.15)
    walls = walls | ((np.abs(y + x / 2.0 + 1.5) < 0.08) & (x > 0.2))
    noise = np.random.default_rng(1).integers(-200, 700, local.seen_ns.shape)
    local.grid.log_odds[:] = np.where(walls, 1300 + noise, -1500)
    local.seen_ns[:] = NOW
    return local


def by_arrays(local: LocalGrid, view: View) -> np.ndarray:
    """(72,) the primary histogram: distance, direction and enlargement of every cell, sector by sector."""
    half, keep = view.window.half, view.window.keep
    steps = np.arange(CELLS) - CELLS // 2
    squared = steps[:, np.newaxis] ** 2 + steps[np.newaxis, :] ** 2
    certainty = np.clip(local.grid.log_odds, 0, 2000) * 15 // 2000
    weight = np.where(
        (squared <= half**2) & (certainty >= LEAST),
        certainty.astype(np.float64) ** 2 * (half**2 + 1.0 - squared),
        0.0,
    )
    bearing = np.arctan2(steps[:, np.newaxis], steps[np.newaxis, :])
    gamma = np.arcsin(np.minimum(keep / np.maximum(np.sqrt(squared) * RESOLUTION, keep), 1.0))
    density = np.zeros(SECTORS)
    for k in range(SECTORS):
        off = np.abs((k * tau / SECTORS - bearing + pi) % tau - pi)
        density[k] = weight[off <= gamma + 1e-9].sum()
    return density


def by_loops(local: LocalGrid, view: View) -> np.ndarray:
    """The same cell by cell."""
    half, keep = view.window.half, view.window.keep
    density = [0.0] * SECTORS
    for row in range(-half, half + 1):
        for col in range(-half, half + 1):
            milli = int(local.grid.log_odds[CELLS // 2 + row, CELLS // 2 + col])
            certainty = min(max(milli, 0), 2000) * 15 // 2000
            squared = row**2 + col**2
            if certainty < LEAST or squared > half**2:
                continue
            distance = max(sqrt(squared) * RESOLUTION, keep)
            gamma = asin(keep / distance) if hypot(row, col) * RESOLUTION > keep else pi / 2.0
            for k in range(SECTORS):
                if abs((k * tau / SECTORS - atan2(row, col) + pi) % tau - pi) <= gamma + 1e-9:
                    density[k] += certainty**2 * (half**2 + 1 - squared)
    return np.array(density)
