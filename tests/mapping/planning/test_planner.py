from math import atan2, cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.planning.floor_plan import FloorPlan
from echogrid.mapping.planning.planner import Planner, Planning
from echogrid.mapping.planning.recollection import Remembering
from echogrid.mapping.pose import Pose, wrap_angle

from .scenes import CELL, DEAD_END, ROOM, U_TRAP, Walls, local_grid, paint, walk

SECOND = 1_000_000_000
KEEP = Planning().prices.keep
WIDE = Planning(relent_ns=5 * SECOND, remembering=Remembering(reach=3.0))
"""All of the room is taken over from its middle."""
WALLED = [(U_TRAP, (5.0, 0.0), 17.0), (ROOM, (4.0, 0.0), 16.0), (DEAD_END, (6.0, 0.0), 12.0)]


@pytest.mark.parametrize(("walls", "goal", "longest"), WALLED, ids=["U-trap", "room", "dead end"])
@pytest.mark.parametrize("y", [-0.3, 0.0, 0.35])
def test_it_comes_out_of_what_is_larger_than_its_window(
    walls: Walls, goal: tuple[float, float], longest: float, y: float
) -> None:
    gone = walk(walls, Pose(0.0, y), goal)
    assert gone.ends_at(*goal)
    assert gone.length < longest
    assert gone.nearest > KEEP - 0.15  # Half a cell of the wall's and half of the robot's.


def test_in_the_open_it_heads_straight_for_the_goal() -> None:
    gone = walk([(-9.0, -9.0, -9.0, 9.0)], Pose(), (4.0, 3.0))
    assert gone.ends_at(4.0, 3.0)
    assert gone.length == approx(5.0, abs=0.15)


def test_near_the_goal_it_tells_the_true_distance_and_bearing() -> None:
    local, robot = local_grid(), Pose(0.33, -0.21, 1.0)
    paint(local, [], robot, SECOND)
    aim = Planner().aim(local, robot, SECOND, (1.02, 0.48))
    assert aim.distance == approx(hypot(0.69, 0.69))
    assert aim.bearing == approx(atan2(0.69, 0.69))


def test_far_from_it_it_tells_the_length_of_the_way() -> None:
    local, robot = local_grid(), Pose()
    paint(local, U_TRAP, robot, SECOND)
    aim = Planner().aim(local, robot, SECOND, (5.0, 0.0))
    assert aim.distance >= 5.0


def test_where_there_is_no_way_it_says_so_and_points_straight() -> None:
    gone = walk(CELL, Pose(), (4.0, 0.0), Planning(relent_ns=None))
    assert not gone.planner.reachable
    local = local_grid()
    paint(local, CELL, Pose(), SECOND)
    assert gone.planner.aim(local, Pose(), 100 * SECOND, (4.0, 0.0)).bearing == approx(0.0)


def test_what_it_no_longer_sees_is_given_up_when_there_is_no_way_for_long() -> None:
    planner, local = Planner(WIDE), local_grid(60)
    paint(local, CELL, Pose(), SECOND)
    planner.aim(local, Pose(), SECOND, (4.0, 0.0))
    assert not planner.reachable
    local.grid.log_odds[:], local.seen_ns[:] = 0, 0
    planner.aim(local, Pose(), 5 * SECOND, (4.0, 0.0))
    assert not planner.reachable
    planner.aim(local, Pose(), 6 * SECOND, (4.0, 0.0))
    assert planner.reachable


def test_walls_that_it_sees_are_not_given_up() -> None:
    planner, local = Planner(WIDE), local_grid(60)
    for second in range(1, 30):
        paint(local, CELL, Pose(), second * SECOND)
        planner.aim(local, Pose(), second * SECOND, (4.0, 0.0))
        assert not planner.reachable


def test_a_door_that_opens_is_found_again() -> None:
    planner, local = Planner(WIDE), local_grid(60)
    paint(local, CELL, Pose(), SECOND)
    planner.aim(local, Pose(), SECOND, (4.0, 0.0))
    assert not planner.reachable
    for second in range(2, 8):
        paint(local, ROOM, Pose(), second * SECOND)
        planner.aim(local, Pose(), second * SECOND, (4.0, 0.0))
    assert planner.reachable


@pytest.mark.parametrize("distance", [0.22, 0.15, 0.1])
def test_a_robot_close_to_a_wall_gets_away_from_it(distance: float) -> None:
    gone = walk([(-2.0, 0.0, 2.0, 0.0)], Pose(0.0, -distance), (0.0, 2.0))
    assert gone.ends_at(0.0, 2.0)


def test_a_goal_close_to_a_wall_is_gone_to_from_its_own_side() -> None:
    gone = walk(ROOM, Pose(-4.0, 0.0), (1.75, 0.0))
    assert gone.ends_at(1.75, 0.0)


def test_a_goal_within_a_wall_is_gone_to_as_near_as_may_be() -> None:
    gone = walk([(2.0, -1.0, 2.0, 1.0)], Pose(), (2.0, 0.0))
    assert hypot(gone.way[-1].x - 2.0, gone.way[-1].y) < KEEP + 0.2


def test_the_same_walk_gives_the_same_way() -> None:
    assert walk(U_TRAP, Pose(), (5.0, 0.0)).way == walk(U_TRAP, Pose(), (5.0, 0.0)).way


def test_of_two_equal_ways_it_keeps_to_the_one_it_took() -> None:
    walls: Walls = [(2.0, -1.5, 2.0, 1.5)]
    planner, local = Planner(), local_grid(80)
    sides = set()
    for step in range(40):
        robot = Pose(0.0, 0.1 if step % 2 else -0.1)
        now_ns = (1 + step) * SECOND
        paint(local, walls, robot, now_ns)
        sides.add(planner.aim(local, robot, now_ns, (4.0, 0.0)).bearing > 0.0)
    assert len(sides) == 1


def test_a_way_that_becomes_blocked_is_left_within_half_a_second() -> None:
    planner, local = Planner(Planning(replan_ns=60 * SECOND)), local_grid(80)
    paint(local, [], Pose(), SECOND)
    assert planner.aim(local, Pose(), SECOND, (3.5, 0.0)).bearing == approx(0.0)
    wall: Walls = [(1.0, -1.0, 1.0, 1.0)]
    for quarter in range(1, 3):
        now_ns = SECOND + quarter * SECOND // 4
        paint(local, wall, Pose(), now_ns)
        aim = planner.aim(local, Pose(), now_ns, (3.5, 0.0))
    assert abs(aim.bearing) > 0.5
    assert aim.distance > 3.8


def test_another_goal_is_planned_for_at_once() -> None:
    planner, local = Planner(), local_grid()
    paint(local, [], Pose(), SECOND)
    planner.aim(local, Pose(), SECOND, (3.0, 0.0))
    assert planner.aim(local, Pose(), SECOND + 1, (-3.0, 0.0)).bearing == approx(3.14159, abs=0.01)


spots = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
BARRIER = FloorPlan(np.array([(2.05, y) for y in np.arange(-2.0, 2.0, 0.05)]), np.empty((0, 2)))
"""4 m wide, across the way east."""


@settings(max_examples=40)
@given(spots, st.floats(-3.0, 3.0), spots, st.floats(-3.0, 3.0), spots)
def test_in_the_open_the_way_in_the_grids_frame_is_straight_whatever_that_frame_is(
    at: tuple[float, float], yaw: float, origin: tuple[float, float], turned: float, goal: tuple[float, float]
) -> None:
    frame, robot = Pose(*origin, turned), Pose(*at, yaw)
    local = local_grid(80, 0.05)  # finer than the memory, or it left cells out where the frame is turned
    there = frame.compose(Pose(*goal))
    paint(local, [], robot, SECOND)
    aim = Planner().aim(local, frame.compose(robot), SECOND, (there.x, there.y), frame)
    far = hypot(goal[0] - at[0], goal[1] - at[1])
    assert aim.distance == approx(far, abs=1e-6)
    if far < 0.1:
        return
    assert wrap_angle(aim.bearing - atan2(goal[1] - at[1], goal[0] - at[0])) == approx(0.0, abs=1e-6)
    assert aim.near <= 1.5 + 0.1 + 1e-6
    for x, y in aim.way:
        share = hypot(x - at[0], y - at[1])
        assert (x, y) == approx(
            (at[0] + share * cos(aim.bearing), at[1] + share * sin(aim.bearing)), abs=1e-6
        )
    assert hypot(aim.way[-1][0] - at[0], aim.way[-1][1] - at[1]) <= 1.6 + 1e-6


def test_where_there_is_no_way_it_points_straight_in_the_grids_frame() -> None:
    frame, local = Pose(1.0, 2.0, 0.5), local_grid()
    paint(local, CELL, Pose(), SECOND)
    planner, goal = Planner(WIDE), frame.compose(Pose(0.0, 4.0))
    aim = planner.aim(local, frame, SECOND, (goal.x, goal.y), frame)
    assert not planner.reachable
    assert (aim.bearing, aim.distance) == (approx(pi / 2.0), approx(4.0))
    assert aim.way == ()


def test_walls_of_a_plan_are_gone_around_before_they_are_seen() -> None:
    local = local_grid()
    paint(local, [], Pose(), SECOND)
    blind = Planner().aim(local, Pose(), SECOND, (4.0, 0.0))
    aim = Planner(plan=BARRIER).aim(local, Pose(), SECOND, (4.0, 0.0))
    assert blind.bearing == approx(0.0)
    assert abs(aim.bearing) > 0.4
    assert aim.distance > 2.0 * hypot(2.0, 2.0)


def test_walls_of_a_plan_are_not_given_up_when_there_is_no_way_for_long() -> None:
    walls = [(x, y) for x, y in np.argwhere(np.ones((41, 41))) * 0.1 - 2.0 if max(abs(x), abs(y)) > 1.95]
    planner, local = Planner(plan=FloorPlan(np.array(walls), np.empty((0, 2)))), local_grid()
    for second in range(1, 20):
        paint(local, [], Pose(), second * SECOND)
        planner.aim(local, Pose(), second * SECOND, (4.0, 0.0))
        assert not planner.reachable


def test_the_way_and_the_carrot_end_where_one_looks_ahead() -> None:
    local = local_grid()
    paint(local, [], Pose(), SECOND)
    aim = Planner(Planning(look_ahead=1.0)).aim(local, Pose(), SECOND, (4.0, 0.0))
    assert 0.9 <= aim.near <= 1.11
    assert aim.way[-1] == approx((aim.near, 0.0))
    assert [y for _, y in aim.way] == approx([0.0] * len(aim.way))
