"""Where a wall that is heard from the side is expected to go on."""

from math import atan2, cos, hypot, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.walls import Walls

CYCLE_NS = 140_000_000
LEFT = Ranger("left", Pose(yaw=pi / 2.0), 0.26, 0.15, 4.0)
AHEAD = Ranger("ahead", Pose(), 0.26, 0.15, 4.0)


def passing(slant: float, cycles: int, ranger: Ranger = LEFT) -> list[tuple[float, float]]:
    """What is expected by a robot on the x axis, 10 cm a cycle, of a wall that comes nearer at a slant (rad)
    and would be met at x = 2; it is heard along the ranger's axis."""
    walls, points = Walls(), []
    for cycle in range(cycles):
        x = 0.1 * cycle
        robot = Pose(x, 0.0, 0.0)
        distance = (2.0 - x) * sin(slant) / cos(slant)
        points = walls.beyond(robot.compose(ranger.mount), ranger, distance, cycle * CYCLE_NS)
    return points


@given(st.floats(0.01, 0.4), st.integers(2, 12))
def test_a_wall_goes_on_in_its_own_direction_from_the_last_echo(slant: float, cycles: int) -> None:
    points = passing(slant, cycles)
    x, y = 0.1 * (cycles - 1), (2.1 - 0.1 * cycles) * sin(slant) / cos(slant)
    assert points[0] == approx((x, y))
    assert len(points) > 4
    for px, py in points[1:]:
        assert atan2(py - y, px - x) == approx(-slant, abs=1e-6)
    assert 0.25 < hypot(points[-1][0] - x, points[-1][1] - y) < 0.4


def test_one_echo_is_no_wall() -> None:
    assert passing(0.2, 1) == []


def test_what_is_straight_ahead_is_no_wall_along_the_way() -> None:
    assert passing(0.2, 5, AHEAD) == []


@pytest.mark.parametrize(
    ("moved", "distance", "later_ns"),
    [
        (0.0, 0.5, CYCLE_NS),
        (0.1, 1.3, CYCLE_NS),
        (0.1, 0.5, 600_000_000),
        (0.5, 0.5, CYCLE_NS),
        (0.1, 0.9, 1),
    ],
    ids=["it stands", "far away", "long ago", "another wall", "a step back"],
)
def test_nothing_is_expected_without_two_near_echoes_of_one_wall(
    moved: float, distance: float, later_ns: int
) -> None:
    walls = Walls()
    walls.beyond(LEFT.mount, LEFT, 0.5, 0)
    assert walls.beyond(Pose(moved, 0.0, pi / 2.0), LEFT, distance, later_ns) == []


def test_the_local_grid_holds_what_is_expected_for_an_obstacle() -> None:
    local = LocalGrid(0.1, 100, 0.1, 10.0, NoEcho.WEAK)
    for cycle in range(3):
        at = Pose(0.1 * cycle, 0.0, pi / 2.0)
        local.fuse(at, LEFT, 0.45, cycle * CYCLE_NS)
    row, col = local.geometry.cell(0.5, 0.45)
    assert local.grid.log_odds[row, col] >= 850
    assert local.seen_ns[row, col] == 2 * CYCLE_NS


def listened(*pings: tuple[float, float | None]) -> LocalGrid:
    """A grid after pings from the origin: yaw, and distance."""
    local = LocalGrid(0.1, 100, 0.1, 10.0, NoEcho.WEAK)
    for number, (yaw, distance) in enumerate(pings):
        local.fuse(Pose(yaw=yaw), LEFT, distance, number + 1)
    return local


STRAIGHT = pi / 2.0, 1.0
"""A smooth wall at y = 1, heard at a right angle."""


@given(st.floats(0.27, 0.5), st.sampled_from([None, 3.0]), st.integers(1, 8))
def test_silence_from_another_direction_erases_no_wall(slant: float, told: float | None, count: int) -> None:
    before = listened(STRAIGHT).grid.log_odds
    after = listened(STRAIGHT, *[(pi / 2.0 - slant, told)] * count).grid.log_odds
    assert (after[before > 0] >= before[before > 0]).all()


def test_nor_does_it_tell_that_the_wall_was_seen() -> None:
    wall = listened(STRAIGHT).grid.log_odds > 0
    after = listened(STRAIGHT, *[(pi / 2.0 - 0.4, 3.0)] * 3)
    assert (after.seen_ns[wall] == 1).all()


@given(st.floats(-0.2, 0.2))
def test_silence_from_its_own_direction_does(slant: float) -> None:
    local = listened(STRAIGHT, *[(pi / 2.0 - slant, 3.0)] * 4)
    assert local.grid.log_odds[local.geometry.cell(0.0, 1.0)] < 0


def test_whoever_heard_it_last_may_take_it_back() -> None:
    aside = pi / 2.0 - 0.2, 1.0
    local = listened(STRAIGHT, aside, *[(pi / 2.0 - 0.4, 3.0)] * 4)
    assert local.grid.log_odds[local.geometry.cell(0.35, 0.95)] < 0
