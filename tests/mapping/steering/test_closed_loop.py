"""A robot that sees all there is, from a start to a goal among pillars and walls."""

from dataclasses import dataclass
from math import hypot, inf, radians
from random import Random

import numpy as np
import pytest

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.steering.decision import Steering
from echogrid.mapping.steering.goal import towards
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.obstacles import Obstacles
from echogrid.mapping.steering.pace import Pace
from echogrid.mapping.steering.recovery import Recovery, Stage
from echogrid.mapping.steering.vff import Vff
from echogrid.mapping.steering.vfh import Vfh
from echogrid.mapping.steering.vfh_plus import VfhPlus
from echogrid.mapping.steering.window import Body, Window
from echogrid.mapping.twist import Twist

RESOLUTION, CELLS = 0.05, 80
BODY, LIMITS = Body(), Limits()
WINDOW = Window(RESOLUTION, CELLS, BODY)
STEP_S = 0.1
METHODS = {"vff": Vff, "vfh": lambda: Vfh(WINDOW), "vfh+": lambda: VfhPlus(WINDOW, LIMITS)}


@dataclass
class Outcome:
    """How a drive ended."""

    arrived: bool
    nearest: float
    """m, of the middle of any occupied cell to base_link."""
    seconds: float
    stage: Stage
    way: list[Pose]


def drive(steering: Steering, walls: np.ndarray, start: Pose, goal: tuple[float, float]) -> Outcome:
    """For 40 s at the most; `walls` (n, 2) are the middles of occupied cells, m."""
    local, obstacles = LocalGrid(RESOLUTION, CELLS, 0.1, 10.0, NoEcho.WEAK), Obstacles(WINDOW)
    pace, recovery = Pace(LIMITS), Recovery(LIMITS)
    robot, twist, way, nearest = start, Twist(), [start], inf
    for step in range(1, round(40.0 / STEP_S)):
        now_ns = round(step * STEP_S * 1e9)
        paint(local, walls, robot, now_ns)
        view, target = obstacles.view(local, robot, now_ns), towards(robot, *goal)
        decision = steering.steer(view, twist.speed, target)
        wish = recovery.wish(now_ns, view, decision, twist) or pace.wish(view, decision)
        twist = LIMITS.reach(wish, twist, STEP_S)
        robot = robot.compose(Pose(twist.speed * STEP_S, 0.0, twist.turn_rate * STEP_S))
        way.append(robot)
        nearest = min(nearest, float(np.hypot(*(walls - (robot.x, robot.y)).T).min()))
        if target.distance < 0.15 or recovery.stage is Stage.STUCK:
            break
    arrived = hypot(robot.x - goal[0], robot.y - goal[1]) < 0.2
    return Outcome(arrived, nearest, step * STEP_S, recovery.stage, way)


def paint(local: LocalGrid, walls: np.ndarray, robot: Pose, now_ns: int) -> None:
    """All within the grid is seen, and sure."""
    local.centre(robot)
    local.seen_ns[:] = now_ns
    local.grid.log_odds[:] = -2000
    rows = np.floor((walls[:, 1] - local.geometry.y) / RESOLUTION).astype(int)
    cols = np.floor((walls[:, 0] - local.geometry.x) / RESOLUTION).astype(int)
    inside = (rows >= 0) & (rows < CELLS) & (cols >= 0) & (cols < CELLS)
    local.grid.log_odds[rows[inside], cols[inside]] = 2000


def filled(inside: np.ndarray, size: int) -> np.ndarray:
    """(n, 2) the middles of the cells of a mask whose middle is the origin."""
    rows, cols = np.nonzero(inside)
    return (np.stack([cols, rows], axis=1) - size // 2 + 0.5) * RESOLUTION


def field(seed: int, pillars: int = 8) -> np.ndarray:
    """A hall of 8 m by 5 m with pillars; both ends are kept clear."""
    random, size = Random(seed), 200
    x = (np.arange(size)[np.newaxis, :] - size // 2 + 0.5) * RESOLUTION
    y = (np.arange(size)[:, np.newaxis] - size // 2 + 0.5) * RESOLUTION
    inside = (np.abs(np.abs(y) - 2.5) < 0.06) & (np.abs(x) < 4.1)
    inside |= (np.abs(np.abs(x) - 4.0) < 0.06) & (np.abs(y) < 2.6)
    for _ in range(pillars):
        at, aside, radius = random.uniform(-2.2, 2.2), random.uniform(-2.0, 2.0), random.uniform(0.05, 0.25)
        inside |= np.hypot(x - at, y - aside) < radius
    return filled(inside, size)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", METHODS)
def test_no_method_ever_touches_what_it_sees(name: str, seed: int) -> None:
    outcome = drive(METHODS[name](), field(seed), Pose(-3.3, 0.3 * seed - 0.5, 0.5), (3.3, 0.2))
    assert outcome.nearest >= BODY.radius


@pytest.mark.parametrize("seed", range(5))
def test_vfh_plus_comes_through_a_field_of_pillars(seed: int) -> None:
    outcome = drive(METHODS["vfh+"](), field(seed), Pose(-3.3, 0.0, radians(170.0)), (3.3, -0.1))
    assert outcome.arrived
    assert outcome.nearest >= BODY.radius
