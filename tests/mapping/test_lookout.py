from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.free_path import STANDING, PathEnd, PathSensor, PathSight
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.lookout import Lookout, Readers
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.planning.floor_plan import FloorPlan
from echogrid.mapping.planning.tracking import PlanTracker
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.stop_layer import StopLayer, StopZone
from echogrid.mapping.twist import Twist
from echogrid.mapping.unknown import Unknown
from echogrid.mapping.verification import Believer
from echogrid.mapping.virtual_sensor import ObstacleView, Sight, StopReason, VirtualSensor

from .outlines import BOX

MS = 1_000_000
SECOND = 1000 * MS
NOW = 100 * SECOND
RESOLUTION, CELLS = 0.1, 60
FRONT = Ranger("front", Pose(0.2), 0.2, 0.05, 4.0)
AHEAD, BACK = Twist(0.3), Twist(-0.3)


class Around:
    """A lookout over a local grid painted by hand, and a front ranger that has just told of 1.9 m."""

    def __init__(
        self,
        unknown: Unknown = Unknown.BLOCKED,
        speaks: bool = True,
        tracker: PlanTracker | None = None,
    ) -> None:
        self.local = LocalGrid(RESOLUTION, CELLS, 0.1, 10.0, NoEcho.WEAK)
        self.local.grid.log_odds[:] = -2000
        self.local.seen_ns[:] = NOW
        readers = Readers(
            VirtualSensor(Sight(unknown=unknown), RESOLUTION, CELLS),
            PathSensor(BOX, PathSight(unknown=unknown), RESOLUTION, CELLS),
            unknown,
            0.1,
            reaction_ns=120 * MS,
        )
        stop = StopLayer((FRONT,), StopZone(0.5, 0.8, SECOND))
        self.lookout = Lookout(self.local, readers, stop, Believer(), tracker)
        if speaks:
            self.hear(80)

    def hear(self, age_ms: int, outcome: Outcome = Outcome.ECHO, distance: float = 1.9) -> None:
        self.lookout.hear([RangeReading(NOW - age_ms * MS, 0, "front", outcome, distance)], NOW)

    def obstacle(self, x: float, y: float) -> None:
        self.local.grid.log_odds[self.local.geometry.cell(x, y)] = 2000

    def view(self, twist: Twist = STANDING, later_ns: int = 0) -> ObstacleView:
        return self.lookout.view(Pose(0.05, 0.05), NOW + later_ns, twist)


def test_free_fresh_and_heard_may_be_driven() -> None:
    view = Around().view(AHEAD)
    assert (view.reason, view.speed_limit, view.allowed, view.silent) == (None, 0.5, AHEAD, ())


def test_the_latency_is_what_was_measured_and_what_follows() -> None:
    view = Around().view()
    assert (view.age_ns, view.latency_ns) == (80 * MS, 200 * MS)


def test_the_older_what_is_heard_the_slower() -> None:
    quick, slow = Around(), Around()
    slow.hear(900)
    for each in (quick, slow):
        each.obstacle(0.85, 0.05)
    assert 0.0 < slow.view().speed_limit < quick.view().speed_limit


def test_an_echo_in_the_zone_stops_ahead_whatever_the_grid_says() -> None:
    around = Around()
    around.hear(10, distance=0.2)
    for twist in (AHEAD, STANDING):
        view = around.view(twist)
        assert (view.reason, view.speed_limit, view.allowed) == (StopReason.NEAR, 0.0, STANDING)


def test_what_is_ahead_does_not_keep_from_backing_off() -> None:
    around = Around()
    around.hear(10, distance=0.2)
    around.obstacle(0.45, 0.05)
    assert around.view(AHEAD).reason is StopReason.NEAR
    assert around.view(BACK).allowed == BACK


def test_who_walks_up_to_the_robot_stops_it_both_ways_until_a_while_later() -> None:
    around, robot = Around(), Pose(0.05, 0.05)
    for cycle, distance in enumerate((1.5, 1.36, 1.22)):
        reading = RangeReading(NOW + cycle * 140 * MS, 0, "front", Outcome.ECHO, distance)
        around.lookout.hear([reading], reading.stamp_ns)
        around.lookout.see([PlacedPing(reading, FRONT, robot.compose(FRONT.mount))], robot, reading.stamp_ns)
    for twist in (AHEAD, BACK, STANDING):
        view = around.view(twist, later_ns=300 * MS)
        assert (view.reason, view.allowed) == (StopReason.NEAR, STANDING)
    turn = Twist(0.0, 0.5)
    assert around.view(turn, later_ns=300 * MS).allowed == turn
    around.local.seen_ns[:] = NOW + 2 * SECOND
    gone_ns = (280 + 1000) * MS
    around.lookout.hear([RangeReading(NOW + gone_ns, 0, "front", Outcome.ECHO, 1.9)], NOW + gone_ns)
    assert 0.0 > around.view(BACK, later_ns=gone_ns - 1).allowed.speed > BACK.speed
    assert around.view(BACK, later_ns=gone_ns).allowed == BACK


@pytest.mark.parametrize("twist", [Twist(5e-324), Twist(0.0, 5e-324), Twist(-1e-310, 1e-310)])
def test_a_twist_that_is_too_small_to_be_one_is_looked_at_as_none(twist: Twist) -> None:
    view = Around().view(twist)
    assert view.path.distance == Around().view().path.distance
    assert view.allowed.stands


@pytest.mark.parametrize("unknown", Unknown)
@pytest.mark.parametrize("twist", [AHEAD, BACK, Twist(0.0, 0.5)])
def test_nothing_is_driven_while_no_ranger_has_told_anything(unknown: Unknown, twist: Twist) -> None:
    view = Around(unknown, speaks=False).view(twist)
    assert (view.reason, view.allowed) == (StopReason.UNKNOWN, STANDING)


def test_what_is_behind_stops_who_backs_off() -> None:
    around = Around()
    around.obstacle(-0.25, 0.05)
    view = around.view(BACK)
    assert (view.reason, view.path.end) == (StopReason.NEAR, PathEnd.OBSTACLE)
    around = Around()
    around.local.seen_ns[:, : CELLS // 2] = 0
    assert around.view(BACK).reason is StopReason.UNKNOWN
    around.local.seen_ns[:, : CELLS // 2] = 1
    assert around.view(BACK).reason is StopReason.STALE


@pytest.mark.parametrize("unknown", Unknown)
def test_a_ranger_ahead_that_falls_silent_stops_and_is_named(unknown: Unknown) -> None:
    around = Around(unknown)
    around.local.seen_ns[:] = NOW + 5 * SECOND
    assert around.view(AHEAD, later_ns=920 * MS).reason is None
    view = around.view(AHEAD, later_ns=921 * MS)
    assert (view.reason, view.silent, view.speed_limit) == (StopReason.SILENT, ("front",), 0.0)
    assert around.view(BACK, later_ns=921 * MS).reason is StopReason.SILENT
    around.lookout.hear([RangeReading(NOW + 900 * MS, 0, "back", Outcome.ECHO, 1.9)], NOW + 900 * MS)
    assert around.view(BACK, later_ns=921 * MS).reason is None


@pytest.mark.parametrize("unknown", Unknown)
def test_before_a_needed_ranger_has_told_anything_nobody_drives_ahead(unknown: Unknown) -> None:
    view = Around(unknown, speaks=False).view(AHEAD)
    assert (view.reason, view.silent, view.age_ns) == (StopReason.UNKNOWN, ("front",), None)


@pytest.mark.parametrize(
    ("unknown", "limit"), [(Unknown.BLOCKED, 0.0), (Unknown.SLOW, 0.1), (Unknown.CLEAR, 0.5)]
)
def test_what_is_unknown_beside_the_way_ahead_stops_slows_or_is_believed(
    unknown: Unknown, limit: float
) -> None:
    around = Around(unknown)
    around.local.seen_ns[CELLS // 2 + 6 :, CELLS // 2 :] = 0
    view = around.view(AHEAD)
    assert (view.speed_limit, view.unknown) == (limit, unknown)


@settings(deadline=None)
@given(
    st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)), max_size=4),
    st.sampled_from([AHEAD, BACK, STANDING, Twist(0.2, 0.6), Twist(0.0, 1.0)]),
    st.sampled_from(Unknown),
    st.integers(0, 2**32 - 1),
)
def test_stop_means_no_speed_and_no_speed_means_stop(
    obstacles: list[tuple[float, float]], twist: Twist, unknown: Unknown, seed: int
) -> None:
    around = Around(unknown)
    for place in obstacles:
        around.obstacle(*place)
    rng = np.random.default_rng(seed)
    around.local.seen_ns[rng.random(around.local.seen_ns.shape) < rng.random()] = 0
    view = around.view(twist)
    assert view.stop == (view.speed_limit == 0.0) == (view.reason is not None)
    if view.stop:
        assert view.allowed == STANDING


@settings(deadline=None)
@given(
    st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)), max_size=4),
    st.sampled_from([AHEAD, BACK, Twist(0.2, 0.6), Twist(-0.2, 0.6), Twist(0.0, 1.0), Twist(5.0, 1.0)]),
    st.sampled_from(Unknown),
    st.booleans(),
)
def test_the_safe_part_of_a_wish_is_its_curve_or_its_turn_as_far_as_a_view_allows_it(
    obstacles: list[tuple[float, float]], wish: Twist, unknown: Unknown, echo: bool
) -> None:
    around = Around(unknown)
    for place in obstacles:
        around.obstacle(*place)
    if echo:
        around.hear(10, distance=0.2)
    view = around.view(wish)
    turn = around.view(Twist(0.0, wish.turn_rate)).allowed if wish.turn_rate else STANDING
    safe = around.lookout.allowed(Pose(0.05, 0.05), NOW, wish)
    assert safe == (turn if view.stop else view.allowed)


def test_who_wishes_for_nothing_stands() -> None:
    assert Around().lookout.allowed(Pose(0.05, 0.05), NOW, STANDING) == STANDING


def test_any_twist_can_be_asked_about() -> None:
    around = Around()
    around.obstacle(1.05, 0.05)
    path = around.lookout.path(Pose(0.05, 0.05), NOW, AHEAD)
    assert path == around.view(AHEAD).path
    assert path.distance == approx(1.0 - 0.2 - 0.0707, abs=1e-3)
    assert replace(path, twist=BACK) != around.lookout.path(Pose(0.05, 0.05), NOW, BACK)


ROBOT = Pose(0.05, 0.05)
WALL = (2.05, 0.05)
"""1.8 m from the front ranger."""


def guided(*walls: tuple[float, float]) -> Around:
    return Around(tracker=PlanTracker(FloorPlan(np.array(walls).reshape(-1, 2), np.empty((0, 2))), Pose()))


def see(around: Around, *distances: float, robot: Pose = ROBOT) -> None:
    for cycle, distance in enumerate(distances):
        reading = RangeReading(NOW + cycle * 100 * MS, 0, "front", Outcome.ECHO, distance)
        around.lookout.see([PlacedPing(reading, FRONT, robot.compose(FRONT.mount))], robot, reading.stamp_ns)


def log_odds(around: Around, x: float, y: float) -> int:
    return int(around.local.grid.log_odds[around.local.geometry.cell(x, y)])


def test_walls_of_a_plan_are_there_before_they_are_heard() -> None:
    around = guided(WALL, (0.05, 1.55), (9.0, 9.0))
    around.lookout.see([], ROBOT, NOW)
    assert (log_odds(around, *WALL), log_odds(around, 0.05, 1.55)) == (2000, 2000)
    assert np.count_nonzero(around.local.grid.log_odds > 0) == 2


def test_walls_of_a_plan_stand_in_the_odom_frame_where_the_drift_puts_them() -> None:
    plan = FloorPlan(np.array([(3.05, 4.05)]), np.empty((0, 2)))
    around = Around(tracker=PlanTracker(plan, Pose(3.0, 2.0, np.pi / 2.0)))
    around.lookout.see([], ROBOT, NOW)
    assert log_odds(around, 2.05, -0.05) == 2000


def test_the_echo_of_a_known_wall_is_no_obstacle_where_it_is_heard() -> None:
    around, plain = guided(WALL), Around()
    for each in (around, plain):
        each.local.grid.log_odds[:] = 0
        see(each, 1.8, 1.8)
    assert np.count_nonzero(plain.local.grid.log_odds > 0) > 1
    assert np.count_nonzero(around.local.grid.log_odds > 0) == 1


def test_who_appears_where_no_wall_is_slows_the_robot_down() -> None:
    """0.75 m before it: room 0.75 - 0.8 * 0.12, slope 0.12 + 0.8 / 0.5."""
    around = guided(WALL)
    see(around, 0.8)
    around.local.grid.log_odds[:] = -2000
    for twist in (AHEAD, BACK, STANDING):
        limit = around.view(twist).path.limit
        assert limit == approx(0.5 * ((1.72**2 + 2.0 * 0.654 / 0.5) ** 0.5 - 1.72), abs=1e-6)


def test_a_known_wall_and_what_answers_where_no_walls_are_known_is_nobody() -> None:
    for around in (guided((1.05, 0.05)), Around()):
        see(around, 0.8)
        around.local.grid.log_odds[:] = -2000
        assert around.view(AHEAD).speed_limit == 0.5


def test_no_obstacle_is_left_beneath_the_robot() -> None:
    around = Around()
    around.local.grid.log_odds[:] = 2000
    around.lookout.see([], ROBOT, NOW)
    x, y = np.meshgrid(around.local.geometry.x_centres - 0.05, around.local.geometry.y_centres - 0.05)
    inside = (np.abs(x) < 0.19) & (np.abs(y) < 0.14)
    assert not around.local.grid.log_odds[inside].any()
    assert (around.local.grid.log_odds[np.hypot(x, y) > 0.3] == 2000).all()
