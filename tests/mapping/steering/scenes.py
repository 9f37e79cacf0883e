"""Painted local grids around a robot, and what hypothesis draws of them."""

from math import pi

from hypothesis import strategies as st

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.steering.decision import Steering
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.obstacles import Belief, Obstacles, View
from echogrid.mapping.steering.vff import Vff
from echogrid.mapping.steering.vfh import Vfh
from echogrid.mapping.steering.vfh_plus import VfhPlus
from echogrid.mapping.steering.window import Body, Window

NOW = 100_000_000_000
RESOLUTION = 0.1
CELLS = 40
MIDDLE = Pose(RESOLUTION / 2.0, RESOLUTION / 2.0)
"""The middle of the cell that has the origin as its corner."""
BODY = Body(radius=0.2, margin=0.1)
WINDOW = Window(RESOLUTION, CELLS, BODY, horizon=1.6)
LIMITS = Limits()
METHODS = ("vff", "vfh", "vfh+")

Cell = tuple[int, int, int]
"""Rows and columns from the middle cell, and milli-nats."""

far = st.integers(-16, 16)
cells = st.tuples(far, far, st.integers(-2000, 2000))
beside = cells.filter(lambda cell: cell[0] ** 2 + cell[1] ** 2 >= 9)
"""Not within the robot."""
worlds = st.lists(beside, max_size=25)
headings = st.floats(-pi, pi)
speeds = st.floats(0.0, 0.5)
within_cell = st.floats(-0.049, 0.049)


def local_grid(world: list[Cell], seen_ns: int = NOW, cells: int = CELLS) -> LocalGrid:
    """All free and fresh but for these cells, the robot in the cell of the origin."""
    local = LocalGrid(RESOLUTION, cells, 0.1, 10.0, NoEcho.WEAK)
    local.grid.log_odds[:] = -2000
    local.seen_ns[:] = seen_ns
    for row, col, milli in world:
        local.grid.log_odds[cells // 2 + row, cells // 2 + col] = milli
    return local


def view_of(world: list[Cell], robot: Pose = MIDDLE, belief: Belief | None = None) -> View:
    return Obstacles(WINDOW, belief).view(local_grid(world), robot, NOW)


def method(name: str, window: Window = WINDOW) -> Steering:
    made = {"vff": Vff, "vfh": lambda: Vfh(window), "vfh+": lambda: VfhPlus(window, LIMITS)}
    return made[name]()


def facing(yaw: float, x: float = 0.0, y: float = 0.0) -> Pose:
    """A robot so far (m) from the middle of its cell."""
    return Pose(MIDDLE.x + x, MIDDLE.y + y, yaw)
