"""Who knows the walls knows by their echoes where it is; what is no wall of the plan moves nothing."""

from math import cos, hypot, inf, pi, radians, sin, sqrt

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pytest import approx
from tests.mapping.strategies import poses

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.planning.floor_plan import FloorPlan, placed
from echogrid.mapping.planning.tracking import PlanTracker, Trust
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.ranger import Ranger

from .rooms import PLAN, RING, START, Wheels, drive

AHEAD = Ranger("ahead", Pose(), radians(15.0), 0.15, 4.0)
TRUST = Trust()
steps = st.builds(Pose, st.floats(-0.3, 0.3), st.floats(-0.1, 0.1), st.floats(-0.6, 0.6))
seeds = st.integers(0, 2**32 - 1)


def ping(distance: float | None, robot: Pose | None = None, ranger: Ranger = AHEAD) -> PlacedPing:
    outcome = Outcome.NO_ECHO if distance is None else Outcome.ECHO
    reading = RangeReading(0, 0, ranger.name, outcome, inf if distance is None else distance)
    return PlacedPing(reading, ranger, (robot or Pose()).compose(ranger.mount))


def plan_of(*points: tuple[float, float]) -> FloorPlan:
    return FloorPlan(np.array(points).reshape(-1, 2), np.empty((0, 2)))


def scattered(seed: int, count: int = 40) -> FloorPlan:
    """Wall points anywhere around, no two of them equally far from anywhere that matters."""
    return FloorPlan(np.random.default_rng(seed).uniform(-4.0, 4.0, (count, 2)), np.empty((0, 2)))


def driven(tracker: PlanTracker, way: list[Pose], seed: int) -> PlanTracker:
    """Over these steps, with an echo from a ring's ranger at any distance after each."""
    rng, odometry = np.random.default_rng(seed), Pose()
    for step in way:
        odometry = odometry.compose(step)
        tracker.move(odometry)
        tracker.explains(ping(float(rng.uniform(0.2, 3.5)), odometry, RING[int(rng.integers(16))]))
    return tracker


@settings(max_examples=10)
@given(st.floats(-0.01, 0.01), st.floats(-1.0, 1.0), st.integers(0, 99))
def test_wheels_off_by_1_percent_and_a_degree_a_metre_are_held_where_the_walls_are(
    scale: float, degrees_per_metre: float, seed: int
) -> None:
    tracker = PlanTracker(PLAN, START)
    went = drive(tracker, Wheels(scale, radians(degrees_per_metre)), 10.0, seed)
    assert went.mean < 0.03
    assert went.most < 0.06
    assert abs(wrap_angle(tracker.pose.yaw - went.truth.yaw)) < radians(2.0)
    assert not tracker.is_lost


def test_without_echoes_the_same_wheels_are_far_off() -> None:
    wheels = Wheels(0.01, radians(1.0))
    went = drive(PlanTracker(plan_of(), START), wheels, 20.0)
    assert went.most > 0.3


@given(poses(), st.lists(steps, max_size=12), seeds)
def test_without_echoes_of_the_plan_it_goes_by_the_wheels_and_only_grows_less_sure(
    start: Pose, way: list[Pose], seed: int
) -> None:
    tracker, odometry, area = PlanTracker(plan_of((90.0, 90.0)), start), Pose(), 0.0
    for step in way:
        odometry = odometry.compose(step)
        tracker.move(odometry)
        assert not tracker.explains(ping(1.0, odometry))
        grown = float(np.linalg.det(tracker._covariance))
        assert grown >= area * (1.0 - 1e-9)
        area = grown
    expected = start.compose(odometry)
    assert (tracker.pose.x, tracker.pose.y) == approx((expected.x, expected.y), abs=1e-9)
    assert wrap_angle(tracker.drift.yaw - start.yaw) == approx(0.0, abs=1e-9)
    assert not tracker.is_lost


def test_a_robot_that_stands_grows_no_less_sure() -> None:
    tracker = PlanTracker(PLAN, START)
    for _ in range(1000):
        tracker.move(Pose())
    assert tracker.deviation == approx((0.01, 0.01, 0.003))


def test_a_metre_ahead_and_a_radian_spread_the_pose_as_is_reckoned_by_hand() -> None:
    tracker = PlanTracker(plan_of(), Pose(0.0, 0.0, pi / 2.0))
    tracker.move(Pose(1.0))
    # North: 0.01^2 + 0.02^2. West: 0.01^2 + (1 m * 0.003)^2 + 0.005^2. Yaw: 0.003^2 + 0.01^2.
    assert tracker.deviation == approx((sqrt(1.34e-4), sqrt(5e-4), sqrt(1.09e-4)))
    tracker.move(Pose(1.0, 0.0, -1.0))
    assert tracker.deviation == approx((sqrt(1.34e-4), sqrt(5e-4), sqrt(1.09e-4 + 9e-4)))


def test_an_echo_that_is_3_cm_short_moves_the_robot_as_is_reckoned_by_hand() -> None:
    tracker = PlanTracker(plan_of((2.0, 0.0)), Pose())
    assert tracker.explains(ping(1.97))
    # S = 0.01^2 + (0.02 + 0.0197)^2, K = -0.01^2 / S.
    assert tracker.pose.x == approx(0.03 * 1e-4 / 1.67609e-3)
    assert (tracker.pose.y, tracker.pose.yaw) == (0.0, 0.0)
    assert tracker.deviation[0] == approx(sqrt(1e-4 - 1e-8 / 1.67609e-3))
    assert tracker.deviation[1:] == approx((0.01, 0.003))


def test_a_wall_aside_of_a_ranger_that_sits_ahead_turns_the_robot() -> None:
    left = Ranger("left", Pose(0.5, 0.0, pi / 2.0), radians(15.0), 0.15, 4.0)
    tracker = PlanTracker(plan_of((0.5, 1.0)), Pose())
    tracker.explains(ping(0.95, ranger=left))
    # d(expected) = -dy - 0.5 dyaw: S = 1e-4 + 0.25 * 9e-6 + (0.02 + 0.0095)^2.
    total = 1.0225e-4 + 0.0295**2
    assert tracker.pose.y == approx(0.05 * 1e-4 / total)
    assert tracker.pose.yaw == approx(0.05 * 0.5 * 9e-6 / total)
    assert tracker.pose.x == approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("echo", "fits"), [(2.12, True), (2.13, False)])
def test_the_gate_is_three_standard_deviations(echo: float, fits: bool) -> None:
    """3 sqrt(0.01^2 + (0.02 + 0.01 * 2.12)^2) = 0.1272 m; 0.1275 m at 2.13 m."""
    tracker = PlanTracker(plan_of((2.0, 0.0)), Pose())
    tracker.explains(ping(echo))
    assert (tracker.pose != Pose()) == fits


@given(st.floats(0.3, 3.0), st.floats(-0.25, 0.25), st.floats(0.15, 3.0))
def test_no_echo_outside_the_gate_moves_the_robot_and_each_within_it_brings_it_nearer(
    away: float, bearing: float, echo: float
) -> None:
    tracker = PlanTracker(plan_of((away * cos(bearing), away * sin(bearing))), Pose())
    before = tracker.deviation
    gate = 3.0 * sqrt(1e-4 + (0.02 + 0.01 * echo) ** 2)
    assume(abs(abs(echo - away) - gate) > 1e-9 and abs(echo - away) > 1e-6)
    tracker.explains(ping(echo))
    if abs(echo - away) > gate:
        assert (tracker.pose, tracker.drift, tracker.deviation) == (Pose(), Pose(), before)
    else:
        now = hypot(away * cos(bearing) - tracker.pose.x, away * sin(bearing) - tracker.pose.y)
        assert abs(echo - now) < abs(echo - away)
        assert min(away, echo) - 1e-9 <= now <= max(away, echo) + 1e-9


@given(seeds, poses(2.0), st.floats(0.05, 0.45), st.floats(0.2, 5.0))
def test_an_echo_is_explained_by_walls_in_the_cone_and_in_the_band_alone(
    seed: int, start: Pose, half_angle: float, echo: float
) -> None:
    plan = scattered(seed)
    seen = []
    for x, y in plan.walls.tolist():
        there = start.inverse().compose(Pose(x, y))
        off = abs(np.arctan2(there.y, there.x))
        away = hypot(there.x, there.y)
        assume(min(abs(off - half_angle), abs(abs(away - echo) - TRUST.band)) > 1e-9)
        seen.append(off < half_angle and abs(away - echo) < TRUST.band)
    ranger = Ranger("any", Pose(), half_angle, 0.15, 6.0)
    assert PlanTracker(plan, start).explains(ping(echo, ranger=ranger)) == any(seen)


@pytest.mark.parametrize("distance", [None, 2.0])
def test_silence_and_the_echo_of_nothing_that_is_known_are_not_explained(distance: float | None) -> None:
    tracker = PlanTracker(plan_of((-2.0, 0.0), (0.0, 2.0)), Pose())
    assert not tracker.explains(ping(distance))
    assert tracker.pose == Pose()


def test_a_far_echo_is_explained_but_tells_nothing_of_the_place() -> None:
    tracker = PlanTracker(plan_of((3.05, 0.0)), Pose())
    assert tracker.explains(ping(3.01))
    assert tracker.pose == Pose()
    assert tracker.explains(ping(2.99))
    assert tracker.pose != Pose()


def test_a_wall_is_not_learned_from_where_something_nearer_stands_aside_of_the_cone() -> None:
    tracker = PlanTracker(plan_of((2.0, 0.0), (1.5 * cos(0.4), 1.5 * sin(0.4))), Pose())
    assert tracker.explains(ping(1.97))
    assert tracker.pose == Pose()


@given(poses(), poses(), seeds, st.lists(steps, max_size=8))
def test_a_plan_and_a_start_that_are_moved_together_move_all_with_them(
    frame: Pose, start: Pose, seed: int, way: list[Pose]
) -> None:
    plan = FloorPlan(placed(scattered(seed).walls, start), np.empty((0, 2)))
    moved = FloorPlan(placed(plan.walls, frame), np.empty((0, 2)))
    here = driven(PlanTracker(plan, start), way, seed)
    there = driven(PlanTracker(moved, frame.compose(start)), way, seed)
    expected = frame.compose(here.drift)
    assert (there.drift.x, there.drift.y) == approx((expected.x, expected.y), abs=1e-6)
    assert wrap_angle(there.drift.yaw - expected.yaw) == approx(0.0, abs=1e-6)


@given(seeds, st.lists(steps, max_size=30))
def test_the_covariance_stays_symmetric_and_positive(seed: int, way: list[Pose]) -> None:
    tracker = driven(PlanTracker(scattered(seed, 200), Pose()), way, seed)
    covariance = tracker._covariance
    assert covariance == approx(covariance.T, abs=1e-15)
    assert np.linalg.eigvalsh(covariance).min() > 0.0


@given(poses(), seeds, st.lists(steps, max_size=12))
def test_the_pose_is_always_the_drift_and_the_odometry(start: Pose, seed: int, way: list[Pose]) -> None:
    tracker, odometry = PlanTracker(scattered(seed, 200), start), Pose()
    for step in way:
        odometry = odometry.compose(step)
    driven(tracker, way, seed)
    expected = tracker.drift.compose(odometry)
    assert (tracker.pose.x, tracker.pose.y) == approx((expected.x, expected.y), abs=1e-9)
    assert wrap_angle(tracker.pose.yaw - expected.yaw) == approx(0.0, abs=1e-9)


def test_echoes_before_a_wall_one_after_the_other_tell_that_it_is_lost() -> None:
    """0.99^104 = 0.352, 0.99^105 = 0.348."""
    tracker = PlanTracker(plan_of((2.0, 0.0)), Pose())
    lost = []
    for _ in range(106):
        tracker.explains(ping(1.0))
        lost.append(tracker.is_lost)
    assert lost.index(True) == 104
    assert tracker.pose == Pose()


@pytest.mark.parametrize("degrees_aside", [30, 60, 120])
def test_who_starts_a_metre_off_askew_to_the_walls_is_soon_lost(degrees_aside: int) -> None:
    aside = Pose(cos(radians(degrees_aside)), sin(radians(degrees_aside)))
    tracker = PlanTracker(PLAN, Pose(START.x + aside.x, START.y + aside.y, START.yaw))
    assert drive(tracker, Wheels(), 4.0).lost


@given(poses(2.0), steps, st.floats(0.5, 3.0))
def test_the_walls_around_the_robot_lie_in_the_odom_frame_where_they_answer(
    start: Pose, step: Pose, reach: float
) -> None:
    tracker = PlanTracker(PLAN, start)
    tracker.move(step)
    found = placed(tracker.walls(step, reach), tracker.drift)
    away = np.hypot(*(PLAN.walls - (tracker.pose.x, tracker.pose.y)).T)
    for point in PLAN.walls[away <= reach - 1e-6]:
        assert np.hypot(*(found - point).T).min() < 1e-6
