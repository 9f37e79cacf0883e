from math import cos, inf, nextafter, pi, sin, tau

from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.pose import Pose, interpolate, wrap_angle

from .strategies import angles, poses


def same(left: Pose, right: Pose) -> bool:
    return (left.x, left.y) == approx((right.x, right.y), abs=1e-9) and abs(
        wrap_angle(left.yaw - right.yaw)
    ) < 1e-9


@given(st.floats(-1e9, 1e9))
def test_a_wrapped_angle_is_the_same_angle_within_half_a_turn(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -pi <= wrapped <= pi
    assert (cos(wrapped), sin(wrapped)) == approx((cos(angle), sin(angle)), abs=abs(angle) * 1e-15 + 1e-12)


@given(st.floats(-pi, pi))
def test_an_angle_within_half_a_turn_is_kept_to_the_bit_and_mirrors(angle: float) -> None:
    assert wrap_angle(angle) == angle
    assert wrap_angle(-angle) == -wrap_angle(angle)


def test_just_below_minus_half_a_turn_is_just_below_half_a_turn() -> None:
    assert wrap_angle(nextafter(-pi, -inf)) <= pi


@given(poses())
def test_a_pose_and_its_inverse_cancel_in_either_order(pose: Pose) -> None:
    assert same(pose.compose(pose.inverse()), Pose())
    assert same(pose.inverse().compose(pose), Pose())


@given(poses(), poses(), poses())
def test_composing_is_associative(a: Pose, b: Pose, c: Pose) -> None:
    assert same(a.compose(b).compose(c), a.compose(b.compose(c)))


@given(poses())
def test_the_origin_changes_nothing(pose: Pose) -> None:
    assert same(pose.compose(Pose()), pose)
    assert same(Pose().compose(pose), pose)


def test_a_sensor_on_the_left_side_of_a_robot_that_faces_north_is_west_of_it() -> None:
    assert same(Pose(2.0, 3.0, pi / 2.0).compose(Pose(0.0, 0.5, pi / 2.0)), Pose(1.5, 3.0, pi))


@given(poses(), poses())
def test_interpolation_starts_at_the_start_and_ends_at_the_end(start: Pose, end: Pose) -> None:
    assert same(interpolate(start, end, 0.0), start)
    assert same(interpolate(start, end, 1.0), end)


@given(angles, angles, st.floats(0.0, 1.0))
def test_interpolation_never_turns_more_than_half_a_turn(start: float, end: float, fraction: float) -> None:
    middle = interpolate(Pose(yaw=start), Pose(yaw=end), fraction)
    turned = abs(wrap_angle(middle.yaw - start))
    assert turned == approx(fraction * abs(wrap_angle(end - start)), abs=1e-9)


def test_from_3_1_to_minus_3_1_rad_the_way_leads_over_pi() -> None:
    quarter = interpolate(Pose(yaw=3.1), Pose(yaw=-3.1), 0.25)
    assert quarter.yaw == approx(3.1207963, abs=1e-6)
    assert quarter.yaw == approx(3.1 + 0.25 * (tau - 6.2), abs=1e-12)
