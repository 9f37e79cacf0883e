import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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
STEP_S = 0.05


def grid(obstacles: list[tuple[float, float]], seen: bool = True) -> LocalGrid:
    local = LocalGrid(RESOLUTION, CELLS, 0.1, 15.0, NoEcho.WEAK)
    local.grid.log_odds[:] = -1500
    local.seen_ns[:] = NOW if seen else 0
    for x, y in obstacles:
        local.grid.log_odds[local.geometry.cell(x, y)] = 2000
    return local


def navigator() -> Navigator:
    window = Window(RESOLUTION, CELLS, Body(0.2, 0.05))
    return Navigator(VfhPlus(window, LIMITS), Obstacles(window), LIMITS)


def asked(local: LocalGrid, twist: Twist, goal: tuple[float, float] = (3.0, 0.0)) -> Course:
    moment = Moment(NOW, Pose(), twist)
    return navigator().steer(local, moment, towards(Pose(), *goal), STEP_S)


def test_in_the_open_it_speeds_up_towards_the_goal() -> None:
    course = asked(grid([]), Twist(0.2))
    assert course.twist.speed == pytest.approx(0.2 + LIMITS.acceleration * STEP_S)
    assert course.twist.turn_rate == pytest.approx(0.0)


near = st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)), max_size=12)


@settings(deadline=None, max_examples=50)
@given(near, st.floats(0.0, 0.5), st.floats(-1.5, 1.5), st.floats(-3.0, 3.0))
def test_what_is_asked_for_can_be_reached(
    obstacles: list[tuple[float, float]], speed: float, turn_rate: float, goal_y: float
) -> None:
    course = asked(grid(obstacles), Twist(speed, turn_rate), (2.0, goal_y))
    assert abs(course.twist.speed) <= abs(speed) + LIMITS.acceleration * STEP_S + 1e-9
    assert abs(course.twist.turn_rate) <= LIMITS.turn_rate
