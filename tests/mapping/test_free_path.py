from math import cos, inf, pi, sin

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.braking import Brakes, stopping_distance
from echogrid.mapping.footprint import Footprint
from echogrid.mapping.free_path import FreePath, PathEnd, PathSensor, PathSight
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.swept_path import fastest
from echogrid.mapping.twist import Twist
from echogrid.mapping.unknown import Unknown

from . import naive_sensor
from .outlines import BOX, ELL, TEE, outlines
from .strategies import poses

SECOND = 1_000_000_000
NOW = 100 * SECOND
RESOLUTION = 0.1
CELLS = 60
LATENCY_S = 0.25
CRUISE = Twist(0.4)
DISC = RESOLUTION * 0.5**0.5

places = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
twists = st.sampled_from(
    [
        Twist(0.4),
        Twist(-0.3),
        Twist(0.4, 0.5),
        Twist(0.3, -1.2),
        Twist(-0.2, 0.8),
        Twist(0.0, 1.0),
        Twist(0.0, -0.7),
        Twist(),
    ]
)
policies = st.sampled_from(Unknown)


class Around:
    """A robot, and a local grid painted by hand: all of it free and fresh, unless said otherwise."""

    def __init__(
        self, robot: Pose | None = None, outline: Footprint = BOX, sight: PathSight | None = None
    ) -> None:
        self.robot = Pose(0.02, 0.07) if robot is None else robot
        self.outline = outline
        self.local = LocalGrid(RESOLUTION, CELLS, 0.1, 10.0, NoEcho.WEAK)
        self.local.centre(self.robot)
        self.local.grid.log_odds[:] = -2000
        self.local.seen_ns[:] = NOW
        self.sensor = PathSensor(outline, sight or PathSight(), RESOLUTION, CELLS)

    def cell(self, place: tuple[float, float]) -> tuple[int, int]:
        at = self.robot.compose(Pose(*place))
        return self.local.geometry.cell(at.x, at.y)

    def obstacle(self, place: tuple[float, float]) -> None:
        self.local.grid.log_odds[self.cell(place)] = 2000

    def seen(self, place: tuple[float, float], radius: float, stamp_ns: int) -> None:
        """When the cells around a place were last spoken of."""
        at, geometry = self.robot.compose(Pose(*place)), self.local.geometry
        dx, dy = geometry.x_centres[np.newaxis, :] - at.x, geometry.y_centres[:, np.newaxis] - at.y
        self.local.seen_ns[np.hypot(dx, dy) <= radius] = stamp_ns

    def look(self, twist: Twist = CRUISE, latency_s: float = LATENCY_S) -> FreePath:
        return self.sensor.look(self.local, self.robot, NOW, twist, latency_s)


def painted(
    robot: Pose, outline: Footprint, unknown: Unknown, obstacles: list[tuple[float, float]]
) -> Around:
    around = Around(robot, outline, PathSight(unknown=unknown))
    for place in obstacles:
        around.obstacle(place)
    return around


def test_free_and_fresh_all_around_leads_to_the_horizon() -> None:
    path = Around().look()
    assert path.end is PathEnd.HORIZON
    assert path.distance == approx(2.0 - 0.25 - DISC)
    assert (path.seconds, path.limit, path.scale) == (inf, 0.5, 1.0)


@pytest.mark.parametrize("distance", [0.6, 1.0, 1.4])
def test_straight_ahead_it_is_the_distance_before_the_front(distance: float) -> None:
    around = Around()
    around.obstacle((distance, 0.0))
    _, col = around.cell((distance, 0.0))
    centre = around.local.geometry.x_centres[col] - around.robot.x
    path = around.look(Twist(0.4))
    assert path.end is PathEnd.OBSTACLE
    assert path.distance == approx(centre - 0.2 - DISC)
    assert path.seconds == approx(path.distance / 0.4)
    expected = stopping_distance(path.limit, LATENCY_S, 0.5)
    assert path.limit == 0.5 or expected == approx(path.distance - 0.05)


@settings(deadline=None, max_examples=40)
@given(
    poses(3.0),
    st.lists(places, min_size=1, max_size=3),
    st.sampled_from([-1.5, 0.01, 0.7]),
    st.sampled_from(Unknown),
)
def test_a_round_robot_turns_in_place_however_near_something_is(
    robot: Pose, obstacles: list[tuple[float, float]], turn_rate: float, unknown: Unknown
) -> None:
    disc = Footprint([(0.2 * cos(a), 0.2 * sin(a)) for a in np.arange(36) * pi / 18.0])
    path = painted(robot, disc, unknown, [*obstacles, (0.22, 0.0)]).look(Twist(0.0, turn_rate))
    assert path.end is PathEnd.HORIZON
    assert path.allowed.turn_rate == approx(turn_rate)


@settings(deadline=None, max_examples=40)
@given(poses(3.0), st.sampled_from([BOX, ELL, TEE]), twists, st.lists(places, min_size=1, max_size=3))
@example(Pose(0.1875), TEE, Twist(-0.3), [(0.0, 0.0)])
def test_it_is_as_long_as_its_twin_says_that_goes_through_the_motion_step_by_step(
    robot: Pose, outline: Footprint, twist: Twist, obstacles: list[tuple[float, float]]
) -> None:
    around = painted(robot, outline, Unknown.CLEAR, obstacles)
    path = around.look(twist)
    course = Twist(1.0) if twist.stands else twist
    speed = fastest(outline, course)
    step = 0.004
    times = [k * step / speed for k in range(1, round(path.distance / step) + 2)]
    twin = around.local, around.robot, outline, course
    assert naive_sensor.seconds(*twin, times) * speed >= path.distance - 1e-6
    if path.end is PathEnd.OBSTACLE:
        assert naive_sensor.seconds(*twin, [path.distance / speed], slack=3e-6) < inf


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 3), st.lists(places, max_size=8), twists, policies)
def test_turning_robot_and_world_by_quarters_changes_nothing(
    quarters: int, obstacles: list[tuple[float, float]], twist: Twist, unknown: Unknown
) -> None:
    straight = painted(Pose(0.05, 0.05, 0.1), ELL, unknown, obstacles)
    turned = painted(Pose(0.05, 0.05, 0.1 + quarters * pi / 2.0), ELL, unknown, [])
    inner = slice(1, None)
    turned.local.grid.log_odds[inner, inner] = np.rot90(
        straight.local.grid.log_odds[inner, inner][::-1], quarters
    )[::-1]
    one, other = straight.look(twist), turned.look(twist)
    assert other.distance == approx(one.distance, abs=1e-6)
    assert other.end is one.end


@settings(deadline=None)
@given(poses(3.0), outlines, twists, policies, st.lists(places, max_size=4), places)
def test_a_further_obstacle_never_lengthens_the_way_nor_raises_the_limit(
    robot: Pose,
    outline: Footprint,
    twist: Twist,
    unknown: Unknown,
    obstacles: list[tuple[float, float]],
    further: tuple[float, float],
) -> None:
    around = painted(robot, outline, unknown, obstacles)
    around.seen((0.5, 0.3), 0.6, 0)
    before = around.look(twist)
    around.obstacle(further)
    around.local.seen_ns[around.cell(further)] = NOW
    after = around.look(twist)
    assert after.distance <= before.distance
    assert after.limit <= before.limit


@settings(deadline=None)
@given(
    poses(3.0),
    outlines,
    twists,
    policies,
    st.lists(places, max_size=3),
    places,
    st.floats(0.1, 2.0),
    st.booleans(),
)
def test_what_is_unknown_or_stale_never_raises_the_limit(
    robot: Pose,
    outline: Footprint,
    twist: Twist,
    unknown: Unknown,
    obstacles: list[tuple[float, float]],
    middle: tuple[float, float],
    radius: float,
    never: bool,
) -> None:
    around = painted(robot, outline, unknown, obstacles)
    around.seen((0.6, -0.2), 0.4, NOW - SECOND)
    before = around.look(twist)
    around.seen(middle, radius, 0 if never else NOW - SECOND)
    after = around.look(twist)
    assert after.limit <= before.limit
    assert after.distance <= before.distance


@settings(deadline=None)
@given(
    poses(3.0),
    outlines,
    twists,
    st.sampled_from([Unknown.BLOCKED, Unknown.CLEAR]),
    st.lists(places, max_size=5),
    st.floats(0.0, 1.0),
    st.builds(Brakes, st.floats(0.05, 5.0), st.floats(0.0, 0.3)),
)
def test_the_limit_always_leaves_the_stopping_distance(
    robot: Pose,
    outline: Footprint,
    twist: Twist,
    unknown: Unknown,
    obstacles: list[tuple[float, float]],
    latency_s: float,
    brakes: Brakes,
) -> None:
    around = Around(robot, outline, PathSight(brakes, unknown))
    for place in obstacles:
        around.obstacle(place)
    around.seen((0.9, 0.0), 0.3, 0)
    path = around.look(twist, latency_s)
    if path.limit > 0.0:
        needed = stopping_distance(path.limit, latency_s, brakes.deceleration)
        assert needed <= (path.distance - brakes.margin) * (1.0 + 1e-9)
    allowed = path.allowed
    assert fastest(outline, allowed) <= path.limit * (1.0 + 1e-9)
    base = abs(allowed.speed)
    if base > 0.0:
        free = path.distance * abs(twist.speed) / fastest(outline, twist)
        assert stopping_distance(base, latency_s, brakes.deceleration) <= free * (1.0 + 1e-9)


@given(twists.filter(lambda twist: twist.speed != 0.0 or twist.stands))
def test_nobody_drives_into_what_nobody_has_ever_seen(twist: Twist) -> None:
    around = Around()
    around.local.seen_ns[:] = 0
    path = around.look(twist)
    assert (path.distance, path.limit, path.end) == (0.0, 0.0, PathEnd.UNKNOWN)


@pytest.mark.parametrize(
    ("unknown", "limit"), [(Unknown.BLOCKED, 0.0), (Unknown.SLOW, 0.1), (Unknown.CLEAR, 0.5)]
)
def test_what_is_unknown_blocks_slows_or_is_believed_to_be_clear(unknown: Unknown, limit: float) -> None:
    around = Around(sight=PathSight(unknown=unknown))
    around.local.seen_ns[:] = 0
    assert around.look().limit == limit


def test_unknown_slows_no_further_than_it_would_block() -> None:
    around = Around(sight=PathSight(unknown=Unknown.SLOW, slow=0.1))
    around.seen((1.6, 0.0), 0.4, 0)
    blocked = Around()
    blocked.seen((1.6, 0.0), 0.4, 0)
    assert around.look().limit == blocked.look().limit > 0.1


@pytest.mark.parametrize(
    ("stamp_ns", "end"),
    [(0, PathEnd.UNKNOWN), (NOW - SECOND, PathEnd.STALE), (NOW - SECOND + 1, PathEnd.HORIZON)],
)
def test_a_gap_in_what_was_seen_lately_ends_the_way_before_it(stamp_ns: int, end: PathEnd) -> None:
    around = Around()
    around.seen((1.3, 0.0), 0.4, stamp_ns)
    path = around.look()
    assert path.end is end
    if end is not PathEnd.HORIZON:
        assert 0.4 <= path.distance <= 0.9 - 0.2


def test_a_gap_between_two_cones_is_bridged_if_enough_beside_it_was_seen() -> None:
    narrow, wide = Around(), Around()
    for ahead in np.arange(0.5, 2.0, 0.05):
        narrow.seen((ahead, 0.12), 0.1, 0)
        wide.seen((ahead, 0.0), 0.3, 0)
    assert narrow.look().end is PathEnd.HORIZON
    assert wide.look().end is PathEnd.UNKNOWN


def test_an_obstacle_seen_afresh_in_the_unknown_is_not_free() -> None:
    around = Around()
    around.local.seen_ns[:] = 0
    for across in np.arange(-0.5, 0.55, 0.1):
        around.obstacle((1.0, across))
        around.local.seen_ns[around.cell((1.0, across))] = NOW
    assert around.look().distance == 0.0


def test_who_turns_on_the_spot_within_its_skin_needs_no_sight() -> None:
    around = Around()
    around.local.seen_ns[:] = 0
    assert around.look(Twist(0.0, 1.0)).end is PathEnd.HORIZON
    around.obstacle((0.0, 0.25))
    assert around.look(Twist(0.0, 1.0)).end is PathEnd.OBSTACLE


def test_a_round_robot_turns_on_the_spot_whatever_stands_beside_it() -> None:
    angles = np.linspace(0.0, 2.0 * pi, 33)[:-1]
    around = Around(outline=Footprint([(0.2 * cos(a), 0.2 * sin(a)) for a in angles]))
    around.obstacle((0.0, 0.32))
    assert around.look(Twist(0.0, 1.0)).end is PathEnd.HORIZON
    assert around.look(Twist(0.0, 1.0)).limit == approx(0.2 * pi / 2.0)


def test_one_that_stands_is_told_how_fast_it_may_set_off_ahead() -> None:
    around = Around()
    around.obstacle((0.8, 0.0))
    standing, driving = around.look(Twist()), around.look(Twist(0.4))
    assert (standing.distance, standing.limit, standing.end) == (driving.distance, driving.limit, driving.end)
    assert (standing.seconds, standing.allowed) == (inf, Twist())


def test_an_obstacle_under_the_robot_is_the_robot() -> None:
    around = Around()
    around.obstacle((0.05, 0.0))
    assert around.look().end is PathEnd.HORIZON


def test_the_limit_is_never_above_that_of_the_drive() -> None:
    sight = PathSight(most=Twist(0.3, 0.5), brakes=Brakes(100.0))
    around = Around(sight=sight)
    assert around.look(Twist(1.0)).allowed == Twist(0.3)
    assert around.look(Twist(0.0, 1.0)).allowed == Twist(0.0, 0.5)
    assert around.look(Twist(0.3, 1.0)).allowed.turn_rate == approx(0.5)


def test_a_course_is_the_same_after_many_others() -> None:
    around = Around()
    for rate in np.linspace(0.1, 1.0, 200):
        around.look(Twist(0.4, float(rate)))
    assert around.look(Twist(0.4, 0.1)) == Around().look(Twist(0.4, 0.1))


@settings(deadline=None, max_examples=60)
@given(poses(3.0), outlines)
def test_beneath_the_robot_are_the_cells_whose_middles_it_covers(robot: Pose, outline: Footprint) -> None:
    around = Around(robot, outline)
    geometry = around.local.geometry
    x, y = np.meshgrid(geometry.x_centres - robot.x, geometry.y_centres - robot.y)
    c, s = cos(robot.yaw), sin(robot.yaw)
    over = outline.contains((c * x + s * y).ravel(), (c * y - s * x).ravel())
    beneath = around.sensor.beneath(around.local, robot)
    assert sorted(beneath.tolist()) == np.flatnonzero(over).tolist()


def test_a_box_of_40_by_30_cm_in_the_middle_of_a_cell_covers_nine_cells() -> None:
    around = Around(Pose(0.05, 0.05), Footprint.box(-0.2, 0.19, 0.14))
    cells = {divmod(cell, CELLS) for cell in around.sensor.beneath(around.local, around.robot).tolist()}
    middle = CELLS // 2
    assert cells >= {(middle + row, middle + col) for row in (-1, 0, 1) for col in (-1, 0, 1)}
    assert {row for row, _ in cells} == {middle - 1, middle, middle + 1}
