"""What comes nearer by itself is met standing; what stands is not taken for it."""

from itertools import pairwise
from math import inf, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.approach import Approach
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger

CYCLE_NS = 140_000_000
CYCLE_S = 0.14
RADIUS = 0.22
RANGER = Ranger("ahead", Pose(0.08), 0.26, 0.15, 4.0)


def ping(cycle: int, robot: Pose, distance: float | None) -> PlacedPing:
    outcome = Outcome.NO_ECHO if distance is None else Outcome.ECHO
    reading = RangeReading(cycle * CYCLE_NS, 0, "ahead", outcome, inf if distance is None else distance)
    return PlacedPing(reading, RANGER, robot.compose(RANGER.mount))


def limit_after(distances: list[float | None], own: float = 0.0, turn: float = 0.0) -> float:
    """m/s at the last of these readings, by a robot at its own speed (m/s) and turn rate (rad/s)."""
    approach = Approach(RADIUS)
    for cycle, distance in enumerate(distances):
        approach.take(ping(cycle, Pose(own * cycle * CYCLE_S, 0.0, turn * cycle * CYCLE_S), distance))
    return approach.limit((len(distances) - 1) * CYCLE_NS, 0.25, 0.8)


def towards(first: float, speed: float, count: int) -> list[float | None]:
    return [first - speed * CYCLE_S * cycle for cycle in range(count)]


@given(st.floats(0.5, 1.5), st.floats(0.2, 1.4))
def test_who_surely_comes_soon_is_met_standing(speed: float, seconds: float) -> None:
    last = RADIUS - RANGER.mount.x + speed * seconds
    assert limit_after(towards(last + 2.0 * speed * CYCLE_S, speed, 3)) == 0.0


@given(st.floats(0.0, 0.78), st.floats(0.6, 3.5), st.integers(2, 4))
def test_a_robot_that_drives_at_a_wall_sees_nothing_come(own: float, away: float, count: int) -> None:
    assert limit_after(towards(away, own, count), own) == inf


def test_the_first_sign_slows_down_to_what_can_be_stopped() -> None:
    near, far = limit_after(towards(1.2, 1.0, 2)), limit_after(towards(2.5, 1.0, 2))
    assert 0.0 < near < far < inf


def test_the_time_that_is_left_runs_while_no_ping_comes() -> None:
    approach = Approach(RADIUS)
    for cycle, distance in enumerate(towards(2.0, 1.0, 2)):
        approach.take(ping(cycle, Pose(), distance))
    limits = [approach.limit(CYCLE_NS + later * 100_000_000, 0.25, 0.8) for later in range(4)]
    assert [before - after for before, after in pairwise(limits)] == approx([0.08] * 3)


@pytest.mark.parametrize("gone", [[None, None, 3.0], [3.0, 3.1, 3.2]], ids=["silence", "it leaves"])
def test_who_goes_is_forgotten_after_a_while(gone: list[float | None]) -> None:
    assert limit_after([*towards(1.2, 1.0, 3), *gone]) == inf


def test_a_leap_is_another_thing() -> None:
    assert limit_after([3.0, 1.2]) == inf


def test_what_a_ranger_hears_while_the_robot_turns_comes_from_elsewhere() -> None:
    assert limit_after(towards(1.2, 1.0, 3), turn=pi / 2.0) == inf


def test_who_walks_beside_a_ranger_of_another_name_tells_nothing_of_this_one() -> None:
    approach = Approach(RADIUS)
    approach.take(ping(0, Pose(), 1.2))
    other = Ranger("aside", Pose(0.08), 0.26, 0.15, 4.0)
    reading = RangeReading(CYCLE_NS, 0, "aside", Outcome.ECHO, 1.06)
    approach.take(PlacedPing(reading, other, other.mount))
    assert approach.limit(CYCLE_NS, 0.25, 0.8) == inf


def moves(distances: list[float | None], own: float = 0.0, turn: float = 0.0) -> list[bool]:
    """What is said of each of these readings."""
    approach = Approach(RADIUS)
    return [
        approach.take(ping(cycle, Pose(own * cycle * CYCLE_S, 0.0, turn * cycle * CYCLE_S), distance))
        for cycle, distance in enumerate(distances)
    ]


@given(st.floats(0.31, 1.99), st.booleans(), st.integers(0, 6))
def test_what_comes_or_goes_by_itself_twice_in_a_row_surely_moves(
    speed: float, leaves: bool, count: int
) -> None:
    way = towards(2.5, -speed if leaves else speed, count)
    assert moves(way) == [cycle >= 2 for cycle in range(count)]


@given(st.floats(-0.5, 0.5), st.floats(0.8, 3.5), st.integers(0, 6))
def test_what_stands_moves_nowhere_however_the_robot_drives(own: float, away: float, count: int) -> None:
    assert not any(moves(towards(away, own, count), own))


@pytest.mark.parametrize(
    "distances",
    [
        [2.0, 1.86, None, 1.72, 1.58],
        [2.0, 1.86, 1.86, 1.72],
        [3.0, 1.2, 3.0, 1.2],
    ],
    ids=["silence between", "a halt between", "leaps"],
)
def test_what_moves_once_or_leaps_is_not_sure_to_move(distances: list[float | None]) -> None:
    assert not any(moves(distances))


def test_to_and_fro_is_movement_too() -> None:
    assert moves([2.0, 1.86, 2.0]) == [False, False, True]


def test_nothing_surely_moves_while_the_robot_turns() -> None:
    assert not any(moves(towards(2.0, 1.0, 4), turn=pi / 2.0))
