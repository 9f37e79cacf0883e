from math import cos, inf, sin

from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.pose import Pose
from echogrid.mapping.steering.goal import ahead, towards

angles = st.floats(-20.0, 20.0)
poses = st.builds(Pose, st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), angles)


@given(poses, st.floats(-9.0, 9.0), st.floats(-9.0, 9.0))
def test_a_point_lies_where_its_goal_says(robot: Pose, x: float, y: float) -> None:
    goal = towards(robot, x, y)
    found = robot.x + goal.distance * cos(goal.bearing), robot.y + goal.distance * sin(goal.bearing)
    assert found == approx((x, y), abs=1e-9)


@given(poses, angles)
def test_a_direction_turns_with_the_robot_and_has_no_end(robot: Pose, bearing: float) -> None:
    goal = ahead(robot, bearing)
    assert goal.distance == inf
    assert (cos(goal.bearing), sin(goal.bearing)) == approx(
        (cos(robot.yaw + bearing), sin(robot.yaw + bearing))
    )


@given(poses, st.floats(-9.0, 9.0), st.floats(-9.0, 9.0))
def test_a_goal_without_a_plan_has_no_way_and_nothing_nearer(robot: Pose, x: float, y: float) -> None:
    for goal in (towards(robot, x, y), ahead(robot)):
        assert (goal.way, goal.near) == ((), inf)
