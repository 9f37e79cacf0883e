from math import cos, pi, radians, sin, tau

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.pose import wrap_angle
from echogrid.mapping.steering.decision import Why
from echogrid.mapping.steering.goal import Goal
from echogrid.mapping.steering.obstacles import Belief, Obstacles
from echogrid.mapping.steering.turning import out_of_reach
from echogrid.mapping.steering.vfh_plus import Costs, VfhPlus, VfhPlusNumbers, directions
from echogrid.mapping.unknown import Unknown

from .scenes import (
    LIMITS,
    MIDDLE,
    NOW,
    WINDOW,
    Cell,
    facing,
    headings,
    local_grid,
    speeds,
    view_of,
    worlds,
)


def blocked_but(free: range) -> np.ndarray:
    blocked = np.ones(72, np.bool_)
    blocked[[k % 72 for k in free]] = False
    return blocked


def wall(ahead: int, first: int, last: int) -> list[Cell]:
    """Cells across the way, so many cells ahead (+x), from row to row."""
    return [(row, ahead, 2000) for row in range(first, last + 1)]


@given(worlds, headings, headings, speeds, st.sampled_from(Unknown))
def test_the_chosen_direction_is_neither_blocked_nor_masked(
    world: list[Cell], yaw: float, bearing: float, speed: float, unknown: Unknown
) -> None:
    steering = VfhPlus(WINDOW, LIMITS)
    view = view_of(world, facing(yaw), Belief(unknown))
    for _ in range(3):
        decision = steering.steer(view, speed, Goal(bearing))
        shut = decision.polar.blocked | decision.polar.masked
        if decision.heading is None:
            assert decision.why is Why.TOUCHING or shut.all()
            continue
        chosen = decision.candidates[0].sector
        assert not shut[int(chosen) % 72]
        assert not shut[int(np.ceil(chosen)) % 72]
        assert abs(wrap_angle(decision.heading - chosen * tau / 72.0)) < 1e-6
        assert [c.cost for c in decision.candidates] == sorted(c.cost for c in decision.candidates)


@pytest.mark.parametrize(
    ("free", "target", "expected"),
    [
        (range(10, 20), 0.0, [14.5]),
        (range(10, 20), 12.0, [14.5]),
        (range(70, 75), 0.0, [72.0]),
        (range(10, 26), 0.0, [17.5]),
        (range(10, 27), 0.0, [18.0, 18.0]),
        (range(10, 41), 0.0, [18.0, 32.0]),
        (range(10, 41), 25.3, [18.0, 32.0, 25.3]),
        (range(10, 41), 12.0, [18.0, 32.0]),
        (range(60, 90), 1.5, [68.0, 81.0, 1.5]),
    ],
)
def test_narrow_openings_are_taken_in_the_middle_wide_ones_at_their_borders_or_towards_the_goal(
    free: range, target: float, expected: list[float]
) -> None:
    found = directions(blocked_but(free), target, 16)
    assert sorted(set(found)) == sorted(set(expected))


@given(st.floats(0.0, 71.9))
def test_where_nothing_is_blocked_the_goal_is_the_only_candidate(target: float) -> None:
    assert directions(np.zeros(72, np.bool_), target, 16) == [target]


def test_a_sector_between_the_thresholds_stays_as_it_was() -> None:
    """Obstacles of falling certainty straight ahead: blocked, still blocked, free, still free, blocked."""
    steering = VfhPlus(WINDOW, LIMITS, VfhPlusNumbers(blocking=0.8, freeing=1.2))
    far, between, near = ([(0, cells, 2000)] for cells in (13, 10, 7))
    found = [
        bool(steering.steer(view_of(world), 0.0, Goal(0.0)).polar.blocked[0])
        for world in (far, between, near, between, far, between, near)
    ]
    assert found == [False, False, True, True, False, False, True]


@given(worlds, worlds)
def test_hysteresis_follows_its_definition(first: list[Cell], second: list[Cell]) -> None:
    steering = VfhPlus(WINDOW, LIMITS)
    before = np.zeros(72, np.bool_)
    for world in (first, second, first):
        polar = steering.steer(view_of(world), 0.0, Goal(0.0)).polar
        expected = [
            True if h > polar.high else False if h < polar.low else was
            for h, was in zip(polar.density.tolist(), before.tolist(), strict=True)
        ]
        assert polar.blocked.tolist() == expected
        before = polar.blocked


def test_what_was_shut_for_want_of_knowledge_is_open_as_soon_as_it_is_known() -> None:
    steering, reader = VfhPlus(WINDOW, LIMITS), Obstacles(WINDOW, Belief(Unknown.BLOCKED))
    assert steering.steer(reader.view(local_grid([], 0), MIDDLE, NOW), 0.0, Goal(0.5)).heading is None
    assert steering.steer(reader.view(local_grid([]), MIDDLE, NOW), 0.0, Goal(0.5)).heading == 0.5


def test_hysteresis_does_not_hold_on_to_what_was_only_shut() -> None:
    """Its density lies between the thresholds: neither blocked by it nor freed by it."""
    steering = VfhPlus(WINDOW, LIMITS, VfhPlusNumbers(blocking=0.8, freeing=1.2))
    reader, world = Obstacles(WINDOW, Belief(Unknown.BLOCKED)), [(0, 10, 2000)]
    for seen_ns, blocked in ((0, True), (NOW, False)):
        view = reader.view(local_grid(world, seen_ns), MIDDLE, NOW)
        assert bool(steering.steer(view, 0.0, Goal(0.0)).polar.blocked[0]) is blocked


def test_the_previous_choice_keeps_the_robot_on_its_side_of_an_obstacle() -> None:
    steering = VfhPlus(WINDOW, LIMITS)
    block = wall(8, -2, 2)
    left = steering.steer(view_of(block, facing(0.1)), 0.0, Goal(0.02)).heading
    assert left is not None and left > 0.0
    assert steering.steer(view_of(block, facing(0.0)), 0.0, Goal(-0.02)).heading == approx(left)
    steering.forget()
    fresh = steering.steer(view_of(block, facing(0.0)), 0.0, Goal(-0.02)).heading
    assert fresh is not None and fresh < 0.0


def test_a_known_way_is_preferred_to_one_that_is_not() -> None:
    """A block ahead; on the left, where it would be shorter, nothing is known."""
    local = local_grid(wall(8, -2, 2))
    local.seen_ns[24:, :] = 0
    headings = []
    for unknown in (Unknown.CLEAR, Unknown.SLOW):
        view = Obstacles(WINDOW, Belief(unknown)).view(local, MIDDLE, NOW)
        headings.append(VfhPlus(WINDOW, LIMITS).steer(view, 0.0, Goal(0.05)).heading)
    assert headings[0] is not None and headings[0] > 0.0
    assert headings[1] is not None and headings[1] < 0.0


def test_a_door_of_80_cm_lets_a_robot_of_40_cm_through_and_one_of_50_does_not() -> None:
    for half, open_ahead in ((4, True), (2, False)):
        door = wall(6, half + 1, 14) + wall(6, -14, -half - 1)
        decision = VfhPlus(WINDOW, LIMITS).steer(view_of(door), 0.0, Goal(0.0))
        assert (decision.heading is not None and abs(decision.heading) < 0.3) == open_ahead


@given(worlds, headings, st.floats(0.01, 3.0))
def test_masks_are_those_of_the_turning_circles(world: list[Cell], yaw: float, radius: float) -> None:
    view = view_of(world, facing(yaw))
    masked = out_of_reach(WINDOW, view.hits, yaw, radius)
    limits = {}
    for side in (1.0, -1.0):
        centre = -side * radius * sin(yaw), side * radius * cos(yaw)
        gap = (
            np.hypot(WINDOW.x[view.hits] - centre[0], WINDOW.y[view.hits] - centre[1]) - radius - WINDOW.keep
        )
        turns = [side * wrap_angle(float(b) - yaw) for b in WINDOW.bearing[view.hits]]
        clashing = [turn for turn, g in zip(turns, gap, strict=True) if turn >= -1e-9 and g < 0.0]
        if np.any(np.abs(gap) < 1e-9) or any(abs(abs(turn) - pi) < 1e-6 for turn in turns):
            return
        limits[side] = min(clashing, default=pi)
    for k in range(72):
        turn = wrap_angle(k * tau / 72.0 - yaw)
        side = 1.0 if turn >= 0.0 else -1.0
        if abs(abs(turn) - limits[side]) > 1e-6 and abs(turn) < pi - 1e-6:
            assert masked[k] == (abs(turn) > limits[side])


def test_straight_back_is_masked_only_if_both_ways_round_are() -> None:
    left, both = [(3, 2, 2000)], [(3, 2, 2000), (-3, 2, 2000)]
    for world, expected in ((left, False), (both, True)):
        hits = view_of(world).hits
        assert bool(out_of_reach(WINDOW, hits, 0.0, 0.3)[36]) is expected


@given(worlds, headings)
def test_a_robot_that_stands_turns_in_place_and_masks_nothing(world: list[Cell], yaw: float) -> None:
    polar = VfhPlus(WINDOW, LIMITS).steer(view_of(world, facing(yaw)), 0.0, Goal(0.0)).polar
    assert not polar.masked.any()


def test_the_faster_the_robot_the_wider_its_circles_and_the_less_it_can_come_to() -> None:
    """Something to the left at 0.6 m: no circle of a slow robot meets it, those of a fast one do."""
    masked = [
        int(VfhPlus(WINDOW, LIMITS).steer(view_of([(6, 0, 2000)]), speed, Goal(0.0)).polar.masked.sum())
        for speed in (0.1, 0.2, 0.5)
    ]
    assert masked == [0, 17, 17]


def test_the_goal_must_weigh_more_than_what_holds_the_robot_back() -> None:
    with pytest.raises(ValueError, match="mu_1"):
        Costs(target=4.0, heading=2.0, previous=2.0)


def test_what_frees_a_sector_is_no_nearer_than_what_blocks_it() -> None:
    with pytest.raises(ValueError, match="blocking <= freeing"):
        VfhPlusNumbers(blocking=1.3, freeing=1.1)


def test_one_sure_cell_blocks_within_its_distance_and_not_beyond() -> None:
    steering = VfhPlus(WINDOW, LIMITS, VfhPlusNumbers(blocking=1.05, freeing=1.05))
    for cells, blocks in ((10, True), (11, False)):
        polar = steering.steer(view_of([(0, cells, 2000)]), 0.0, Goal(radians(180.0))).polar
        assert bool(polar.blocked[0]) is blocks
