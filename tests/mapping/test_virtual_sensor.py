from dataclasses import replace
from itertools import pairwise
from math import cos, inf, pi, sin, tau

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.unknown import Unknown
from echogrid.mapping.virtual_sensor import (
    Ahead,
    ObstacleView,
    SectorState,
    Sight,
    StopReason,
    VirtualSensor,
)

from . import naive_sensor
from .strategies import poses

SECOND = 1_000_000_000
NOW = 100 * SECOND
RESOLUTION = 0.1
CELLS = 60
OFF = 0.75 * RESOLUTION
"""m: a point lies no further from the middle of its cell."""

headings = st.floats(-pi, pi)


class Around:
    """A robot, and a local grid painted by hand: all of it free and fresh, unless said otherwise."""

    def __init__(self, robot: Pose | None = None, sight: Sight | None = None) -> None:
        self.robot = Pose(0.02, 0.07, 0.0) if robot is None else robot
        self.local = LocalGrid(RESOLUTION, CELLS, 0.1, 10.0, NoEcho.WEAK)
        self.local.centre(self.robot)
        self.local.grid.log_odds[:] = -2000
        self.local.seen_ns[:] = NOW
        self._sensor = VirtualSensor(Sight() if sight is None else sight, RESOLUTION, CELLS)

    def obstacle(self, bearing: float, distance: float, milli: int = 2000) -> None:
        heading = self.robot.yaw + bearing
        x, y = self.robot.x + distance * cos(heading), self.robot.y + distance * sin(heading)
        self.local.grid.log_odds[self.local.geometry.cell(x, y)] = milli

    def seen(self, bearing: float, half_width: float, stamp_ns: int) -> None:
        """When all cells within a wedge were last spoken of."""
        geometry = self.local.geometry
        dx = geometry.x_centres[np.newaxis, :] - self.robot.x
        dy = geometry.y_centres[:, np.newaxis] - self.robot.y
        off = np.angle(np.exp(1j * (np.arctan2(dy, dx) - self.robot.yaw - bearing)))
        self.local.seen_ns[np.abs(off) <= half_width] = stamp_ns

    def view(self) -> ObstacleView:
        return self._sensor.view(self.local, self.robot, NOW)

    def ahead(self) -> Ahead:
        return self._sensor.ahead(self.local, self.robot, NOW)

    def states(self) -> list[SectorState]:
        return [sector.state for sector in self.view().sectors]


def test_a_grid_of_which_nothing_was_seen_is_unknown_and_stops() -> None:
    around = Around()
    around.local.grid.log_odds[:] = 0
    around.local.seen_ns[:] = 0
    assert set(around.states()) == {SectorState.UNKNOWN}
    assert around.view().stop


def test_free_and_fresh_all_around_is_clear_and_does_not_stop() -> None:
    around = Around()
    view = around.view()
    assert {(sector.state, sector.nearest) for sector in view.sectors} == {(SectorState.CLEAR, inf)}
    assert not view.stop
    assert view.stamp_ns == NOW


@settings(deadline=None)
@given(
    poses(5.0),
    st.sampled_from(Unknown),
    st.sampled_from([4, 7, 16, 72]),
    st.lists(st.tuples(headings, st.floats(0.2, 1.9)), max_size=5),
    st.integers(0, 2**32 - 1),
)
def test_what_is_ahead_is_what_the_view_says_of_it(
    robot: Pose, unknown: Unknown, count: int, obstacles: list[tuple[float, float]], seed: int
) -> None:
    around = Around(robot, Sight(unknown=unknown, sectors=count))
    for bearing, distance in obstacles:
        around.obstacle(bearing, distance)
    rng = np.random.default_rng(seed)
    around.local.seen_ns[rng.random(around.local.seen_ns.shape) < rng.random()] = rng.integers(2)
    view, ahead = around.view(), around.ahead()
    looked_at = [sector for sector in view.sectors if abs(sector.bearing) <= pi / 4.0 + 1e-9]
    doubtful = any(sector.state in (SectorState.UNKNOWN, SectorState.STALE) for sector in looked_at)
    assert (ahead.reason, ahead.doubtful) == (view.reason, doubtful)


@settings(deadline=None)
@given(poses(5.0), st.integers(0, 15), st.floats(0.9, 1.8))
def test_an_obstacle_blocks_its_sector_alone_however_robot_and_world_are_turned(
    robot: Pose, sector: int, distance: float
) -> None:
    around = Around(robot)
    around.obstacle(sector * tau / 16, distance)
    view = around.view()
    assert view.sectors[sector].state is SectorState.BLOCKED
    assert view.sectors[sector].nearest == approx(distance, abs=OFF)
    assert [n for n, each in enumerate(view.sectors) if each.state is not SectorState.CLEAR] == [sector]
    assert view.nearest is view.sectors[sector]


@settings(deadline=None)
@given(headings, st.lists(st.tuples(headings, st.floats(0.3, 1.8)), min_size=1, max_size=5))
def test_turning_robot_and_world_together_changes_the_nearest_distance_by_a_cell_s_diagonal_at_most(
    yaw: float, obstacles: list[tuple[float, float]]
) -> None:
    straight, turned = Around(Pose(0.05, 0.05, 0.0)), Around(Pose(0.05, 0.05, yaw))
    for bearing, distance in obstacles:
        straight.obstacle(bearing, distance)
        turned.obstacle(bearing, distance)
    assert turned.view().nearest.nearest == approx(straight.view().nearest.nearest, abs=2.0 * OFF)


@settings(deadline=None)
@given(st.integers(0, 3), st.lists(st.tuples(headings, st.floats(0.3, 1.9)), max_size=8), st.integers(1, 4))
def test_turning_robot_and_world_by_quarters_changes_nothing(
    quarters: int, obstacles: list[tuple[float, float]], step: int
) -> None:
    """The window has an even number of cells: its middle is a cell, and its south-west has one cell more."""
    straight = Around(Pose(0.05, 0.05, 0.1 * step))
    turned = Around(Pose(0.05, 0.05, 0.1 * step + quarters * pi / 2.0))
    for bearing, distance in obstacles:
        straight.obstacle(bearing, distance)
    middle = CELLS // 2
    inner = slice(1, None)
    world = straight.local.grid.log_odds[inner, inner]
    assert world.shape[0] == 2 * middle - 1
    turned.local.grid.log_odds[inner, inner] = np.rot90(world[::-1], quarters)[::-1]
    for one, other in zip(straight.view().sectors, turned.view().sectors, strict=True):
        assert one.state is other.state
        assert one.nearest == approx(other.nearest)


def test_only_cells_that_are_likely_enough_are_obstacles() -> None:
    around = Around()
    around.obstacle(0.0, 1.0, 849)
    assert around.view().nearest.nearest == inf
    around.obstacle(0.0, 1.0, 850)
    assert around.view().nearest.nearest < inf


def test_obstacles_beyond_the_horizon_are_not_seen() -> None:
    around = Around()
    around.obstacle(0.0, 2.2)
    assert set(around.states()) == {SectorState.CLEAR}


@pytest.mark.parametrize(
    ("distance", "stops"), [(0.3, True), (0.4, True), (0.5 - OFF, True), (0.5 + OFF, False), (1.0, False)]
)
def test_something_ahead_within_the_stop_distance_stops(distance: float, stops: bool) -> None:
    around = Around()
    around.obstacle(0.0, distance)
    assert around.view().reason is (StopReason.NEAR if stops else None)


@pytest.mark.parametrize("sectors", range(8, 361, 8))
def test_ahead_is_the_same_on_both_sides(sectors: int) -> None:
    """45 degrees are the middle of a sector here."""
    stops = []
    for side in (1.0, -1.0):
        around = Around(Pose(0.05, 0.05), Sight(sectors=sectors, known=0.0))
        around.obstacle(side * pi / 4.0, 0.4)
        stops.append(around.view().stop)
    assert stops == [True, True]


@pytest.mark.parametrize("sectors", [4, 7, 16, 36, 359, 360])
def test_the_sectors_go_counter_clockwise_from_straight_ahead(sectors: int) -> None:
    bearings = [sector.bearing for sector in Around(sight=Sight(sectors=sectors)).view().sectors]
    assert len(bearings) == sectors
    assert bearings[0] == 0.0
    steps = [wrap_angle(after - before) for before, after in pairwise(bearings)]
    assert steps == approx([tau / sectors] * (sectors - 1))


def test_an_obstacle_behind_does_not_stop() -> None:
    around = Around()
    around.obstacle(pi, 0.3)
    assert not around.view().stop


@pytest.mark.parametrize(
    ("bearing", "stops"), [(0.0, True), (pi / 4.0, True), (-pi / 4.0, True), (pi, False)]
)
def test_what_is_unknown_ahead_stops(bearing: float, stops: bool) -> None:
    around = Around()
    around.seen(bearing, pi / 12.0, 0)
    assert SectorState.UNKNOWN in around.states()
    assert around.view().reason is (StopReason.UNKNOWN if stops else None)


@pytest.mark.parametrize(
    ("bearing", "stops"), [(0.0, True), (pi / 4.0, True), (-pi / 4.0, True), (pi, False)]
)
def test_what_is_stale_ahead_stops(bearing: float, stops: bool) -> None:
    around = Around()
    around.seen(bearing, pi / 12.0, NOW - SECOND)
    assert SectorState.STALE in around.states()
    assert around.view().reason is (StopReason.STALE if stops else None)


def test_what_is_near_is_told_before_what_is_unknown_and_that_before_what_is_stale() -> None:
    around = Around()
    around.local.seen_ns[:] = 1
    around.seen(pi / 4.0, pi / 12.0, 0)
    assert around.view().reason is StopReason.UNKNOWN
    around.obstacle(0.0, 0.4)
    assert around.view().reason is StopReason.NEAR


def test_a_sector_is_fresh_until_it_is_stale() -> None:
    around = Around()
    around.local.seen_ns[:] = NOW - SECOND + 1
    assert set(around.states()) == {SectorState.CLEAR}
    around.local.seen_ns[:] = NOW - SECOND
    assert set(around.states()) == {SectorState.STALE}


def test_a_few_fresh_cells_do_not_make_an_old_sector_clear() -> None:
    """A neighbour's cone grazes the sector of a ranger that has fallen silent."""
    around = Around()
    around.local.seen_ns[:] = 1
    around.seen(0.0, 0.03, NOW)
    assert around.states()[0] is SectorState.STALE
    assert around.view().stop


def test_an_obstacle_that_was_not_confirmed_lately_is_stale_and_keeps_its_distance() -> None:
    around = Around()
    around.obstacle(0.0, 1.0)
    around.local.seen_ns[:] = 1
    sector = around.view().sectors[0]
    assert sector.state is SectorState.STALE
    assert sector.nearest == approx(1.0, abs=OFF)


def test_a_fresh_obstacle_blocks_though_nothing_is_known_behind_it() -> None:
    around = Around()
    around.local.seen_ns[:] = 0
    around.local.grid.log_odds[:] = 0
    around.obstacle(0.0, 0.4)
    around.local.seen_ns[around.local.grid.log_odds > 0] = NOW
    assert around.states()[0] is SectorState.BLOCKED
    assert around.view().stop


@given(st.integers(4, 64), st.floats(0.0, 1.0))
def test_a_sector_is_clear_only_if_enough_of_it_was_seen(sectors: int, part: float) -> None:
    around = Around(sight=Sight(sectors=sectors))
    rng = np.random.default_rng(sectors)
    unseen = rng.random(around.local.seen_ns.shape) >= part
    around.local.seen_ns[unseen] = 0
    states = set(around.states())
    if part > 0.9:
        assert states == {SectorState.CLEAR}
    if part < 0.05 and sectors <= 8:
        assert states == {SectorState.UNKNOWN}
    assert states <= {SectorState.CLEAR, SectorState.UNKNOWN}


@settings(deadline=None, max_examples=25)
@given(poses(3.0), st.integers(4, 40), st.integers(0, 2**32 - 1))
def test_the_sectors_are_those_of_the_twin_that_goes_through_them_cell_by_cell(
    robot: Pose, count: int, seed: int
) -> None:
    robot = replace(robot, yaw=robot.yaw + 0.01234)  # no cell lies on a border between two sectors
    around, rng = Around(robot, Sight(sectors=count)), np.random.default_rng(seed)
    around.local.grid.log_odds[:] = rng.choice(
        [-2000, 849, 850], around.local.seen_ns.shape, p=[0.7, 0.2, 0.1]
    )
    around.local.seen_ns[:] = rng.choice([0, 1, NOW], around.local.seen_ns.shape)
    twin = naive_sensor.sectors(around.local, robot, NOW, count, 2.0)
    for sector, naive in zip(around.view().sectors, twin, strict=True):
        assert sector.nearest == approx(naive.nearest)
        assert sector.seen == approx(naive.seen)


@settings(deadline=None)
@given(st.integers(0, 3), st.integers(0, 2**32 - 1))
def test_turning_robot_and_world_by_quarters_changes_neither_confidence_nor_age_nor_what_was_seen(
    quarters: int, seed: int
) -> None:
    straight = Around(Pose(0.05, 0.05, 0.1))
    turned = Around(Pose(0.05, 0.05, 0.1 + quarters * pi / 2.0))
    rng, shape = np.random.default_rng(seed), straight.local.seen_ns.shape
    straight.local.grid.log_odds[:] = rng.choice([-1000, 0, 900], shape, p=[0.5, 0.48, 0.02])
    straight.local.seen_ns[:] = rng.integers(0, NOW, shape)
    straight.local.seen_ns[straight.local.grid.log_odds == 900] = NOW - 7  # of two as near it may be either
    inner = slice(1, None)
    for one, other in (
        (straight.local.grid.log_odds, turned.local.grid.log_odds),
        (straight.local.seen_ns, turned.local.seen_ns),
    ):
        other[inner, inner] = np.rot90(one[inner, inner][::-1], quarters)[::-1]
    for before, after in zip(straight.view().sectors, turned.view().sectors, strict=True):
        assert after.confidence == approx(before.confidence)
        assert after.seen == approx(before.seen)
        assert (after.age_ns, after.state) == (before.age_ns, before.state)


@pytest.mark.parametrize(("milli", "probability"), [(850, 0.7006), (2000, 0.8808)])
def test_an_obstacle_is_as_sure_as_its_cell_is_occupied_and_as_old_as_that(
    milli: int, probability: float
) -> None:
    around = Around()
    around.seen(0.0, 3.2, NOW - 5)
    around.obstacle(0.0, 1.0, milli)
    around.obstacle(0.0, 1.5, 2000 - milli + 850)
    around.local.seen_ns[around.local.grid.log_odds == milli] = NOW - 400
    sector = around.view().sectors[0]
    assert sector.confidence == approx(probability, abs=1e-4)
    assert sector.age_ns == 400


def test_what_is_clear_is_the_surer_the_more_of_it_was_seen() -> None:
    around = Around()
    everything = around.view().sectors[0]
    around.seen(0.1, 0.1, 1)
    part = around.view().sectors[0]
    assert everything.confidence == approx(0.8808, abs=1e-4)
    assert everything.seen == 1.0
    assert part.seen == approx(0.5, abs=0.2)
    assert part.confidence == approx(0.8808 * part.seen, abs=1e-4)


def test_the_gap_between_two_cones_is_unseen() -> None:
    """Two rangers look 45 deg apart; what is between their cones nobody knows."""
    around = Around(sight=Sight(sectors=16))
    around.local.seen_ns[:] = 0
    for bearing in (0.0, pi / 4.0):
        around.seen(bearing, pi / 16.0, NOW)
    states = around.states()
    assert states[:3] == [SectorState.CLEAR, SectorState.UNKNOWN, SectorState.CLEAR]
    assert around.view().sectors[1].seen < 0.1


def test_a_sector_of_which_nothing_was_ever_seen_has_no_age_and_no_confidence() -> None:
    around = Around()
    around.local.seen_ns[:] = 0
    sector = around.view().sectors[0]
    assert (sector.age_ns, sector.confidence, sector.seen) == (None, 0.0, 0.0)


@pytest.mark.parametrize("unknown", [Unknown.SLOW, Unknown.CLEAR])
def test_what_is_unknown_need_not_stop_but_is_shown_and_so_is_that(unknown: Unknown) -> None:
    around = Around(sight=Sight(unknown=unknown))
    around.local.seen_ns[:] = 0
    view = around.view()
    assert {sector.state for sector in view.sectors} == {SectorState.UNKNOWN}
    assert (view.reason, view.unknown) == (None, unknown)
    around.obstacle(0.0, 0.4)
    assert around.view().reason is StopReason.NEAR
