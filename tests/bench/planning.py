"""What planning costs: on 200 x 200 cells, and its wave beside a twin that goes cell by cell."""

import heapq
from collections.abc import Callable, Iterator
from math import cos, inf, sin, sqrt

import numpy as np
from tests.bench.stopwatch import Row, least_us

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.planning.planner import Planner
from echogrid.mapping.planning.recollection import Recollection
from echogrid.mapping.planning.route import found
from echogrid.mapping.planning.terrain import Prices, terrain
from echogrid.mapping.planning.wavefront import Cell, cost_to_go
from echogrid.mapping.pose import Pose
from echogrid.mapping.sonar_model import NoEcho

CELLS = 200
STEP_NS = 50_000_000
GOAL, START = (2, 2), (CELLS - 3, CELLS - 3)


def rows() -> Iterator[Row]:
    """What is measured."""
    open_floor, serpent = np.ones((CELLS, CELLS)), winding()
    assert np.allclose(cost_to_go(serpent, GOAL), cell_by_cell(serpent, GOAL))
    beside = "the same cell by cell, with a heap"
    for name, floor in (("nothing in it", open_floor), ("nine walls to wind through", serpent)):
        wave, twin = (
            each_us(lambda f=floor: cost_to_go(f, GOAL)),
            each_us(lambda f=floor: cell_by_cell(f, GOAL)),
        )
        yield Row(f"a wave over {CELLS} x {CELLS} cells, {name}", wave, beside, twin)
    memory = walls()
    ground = terrain(memory, Prices(), ())
    here, goal = ground.middle(START), ground.middle(GOAL)
    yield Row("the ground of the latter from the memory", each_us(lambda: terrain(memory, Prices(), ())))
    yield Row("the way through it, pulled tight", each_us(lambda: found(ground, here, goal)))
    yield Row("a step of a robot that drives, plans among them, on the mean", least_us(driven))


def each_us(work: Callable[[], object]) -> float:
    """Microseconds of one turn."""

    def once() -> int:
        work()
        return 1

    return least_us(once)


def walls() -> Recollection:
    """Nine walls from side to side, each open at the other end."""
    memory = Recollection()
    middle = CELLS * 0.05
    memory.cover(middle, middle, middle)
    memory.belief = np.full((CELLS, CELLS), -1, np.int8)
    for number, row in enumerate(range(20, CELLS, 20)):
        gap = slice(0, 15) if number % 2 else slice(CELLS - 15, CELLS)
        memory.belief[row] = 1
        memory.belief[row, gap] = -1
    return memory


def winding() -> np.ndarray:
    """What its cells cost."""
    return terrain(walls(), Prices(), ()).weights


def cell_by_cell(weights: np.ndarray, goal: Cell) -> np.ndarray:
    """Dijkstra, one cell at a time."""
    padded = np.pad(weights, 1, constant_values=inf)
    width = padded.shape[1]
    weight = padded.ravel().tolist()
    steps = [
        (down * width + right, sqrt(0.5) if down and right else 0.5)
        for down in (-1, 0, 1)
        for right in (-1, 0, 1)
        if down or right
    ]
    start = (goal[0] + 1) * width + goal[1] + 1
    cost = [inf] * len(weight)
    cost[start] = 0.0
    queue = [(0.0, start)]
    while queue:
        so_far, here = heapq.heappop(queue)
        if so_far > cost[here]:
            continue
        for offset, half in steps:
            offered = so_far + half * (weight[here] + weight[here + offset])
            if offered < cost[here + offset]:
                cost[here + offset] = offered
                heapq.heappush(queue, (offered, here + offset))
    return np.array(cost).reshape(padded.shape)[1:-1, 1:-1]


def driven() -> int:
    """Ten seconds at 0.5 m/s past a wall towards a goal 12 m away."""
    planner, local = Planner(), LocalGrid(0.1, 60, 0.1, 15.0, NoEcho.WEAK)
    robot, turns = Pose(), 200
    for turn in range(1, turns + 1):
        local.centre(robot)
        local.seen_ns[:] = turn * STEP_NS
        x, y = local.geometry.x_centres[np.newaxis, :], local.geometry.y_centres[:, np.newaxis]
        local.grid.log_odds[:] = np.where((np.abs(x - 3.0) < 0.06) & (np.abs(y) < 2.0), 2000, -2000)
        aim = planner.aim(local, robot, turn * STEP_NS, (12.0, 0.0))
        robot = Pose(robot.x + 0.025 * cos(aim.bearing), robot.y + 0.025 * sin(aim.bearing), aim.bearing)
    return turns
