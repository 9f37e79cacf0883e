from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping.braking import Brakes
from echogrid.mapping.footprint import Footprint
from echogrid.mapping.free_path import PathSensor, PathSight
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.steering.goal import towards
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.navigator import Course, Moment, Navigator
from echogrid.mapping.steering.obstacles import Obstacles
from echogrid.mapping.steering.vfh_plus import VfhPlus
from echogrid.mapping.steering.window import Body, Window
from echogrid.mapping.twist import Twist

NOW = 2_000_000_000
RESOLUTION, CELLS = 0.05, 120
LIMITS = Limits(0.5, 1.5, 0.5, 3.0)
STEP_S, LATENCY_S = 0.05, 0.25


def grid(obstacles: list[tuple[float, float]], seen: bool = True) -> LocalGrid:
    local = LocalGrid(RESOLUTION, CELLS, 0.1, 15.0, NoEcho.WEAK)
    local.grid.log_odds[:] = -1500
    local.seen_ns[:] = NOW if seen else 0
    for x, y in obstacles:
        local.grid.log_odds[local.geometry.cell(x, y)] = 2000
    return local


def navigator() -> Navigator:
    window = Window(RESOLUTION, CELLS, Body(0.2, 0.05))
    corners = [(0.2 * np.cos(a), 0.2 * np.sin(a)) for a in np.arange(24) * pi / 12.0]
    path = PathSensor(Footprint(corners), PathSight(Brakes(0.5, 0.05)), RESOLUTION, CELLS)
    return Navigator(VfhPlus(window, LIMITS), Obstacles(window), path, LIMITS)


def asked(local: LocalGrid, twist: Twist, goal: tuple[float, float] = (3.0, 0.0)) -> Course:
    moment = Moment(NOW, Pose(), twist)
    return navigator().steer(local, moment, towards(Pose(), *goal), STEP_S, LATENCY_S)


def test_in_the_open_it_speeds_up_towards_the_goal() -> None:
    course = asked(grid([]), Twist(0.2))
    assert course.twist.speed == pytest.approx(0.2 + LIMITS.acceleration * STEP_S)
    assert course.twist.turn_rate == pytest.approx(0.0)


def test_into_what_nobody_has_seen_it_does_not_drive() -> None:
    assert asked(grid([], seen=False), Twist()).twist.speed == 0.0


def test_before_a_wall_it_brakes_whatever_was_wished_for() -> None:
    wall = [(0.45, y) for y in np.arange(-1.0, 1.0, RESOLUTION)]
    assert asked(grid(wall), Twist(0.5)).twist.speed < 0.35


near = st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)), max_size=12)


@settings(deadline=None, max_examples=50)
@given(near, st.floats(0.0, 0.5), st.floats(-1.5, 1.5), st.floats(-3.0, 3.0))
def test_what_is_asked_for_can_be_reached_and_leaves_the_stopping_distance(
    obstacles: list[tuple[float, float]], speed: float, turn_rate: float, goal_y: float
) -> None:
    course = asked(grid(obstacles), Twist(speed, turn_rate), (2.0, goal_y))
    assert abs(course.twist.speed) <= abs(speed) + LIMITS.acceleration * STEP_S + 1e-9
    assert abs(course.twist.turn_rate) <= LIMITS.turn_rate
    if course.twist.speed:
        assert abs(course.twist.speed) <= abs(course.path.allowed.speed) + 1e-9
