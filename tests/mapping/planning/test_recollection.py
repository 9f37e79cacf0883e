from math import cos, floor, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.planning.floor_plan import FloorPlan
from echogrid.mapping.planning.recollection import Recollection, Remembering
from echogrid.mapping.pose import Pose

from .scenes import local_grid

SECOND = 1_000_000_000
places = st.floats(-20.0, 20.0)


def at(memory: Recollection, x: float, y: float) -> int:
    return int(memory.belief[memory.geometry.cell(x, y)])


def grid(robot: Pose, log_odds: int, seen_ns: int, resolution: float = 0.1) -> LocalGrid:
    """All over the same."""
    local = local_grid(resolution=resolution)
    local.centre(robot)
    local.grid.log_odds[:] = log_odds
    local.seen_ns[:] = seen_ns
    return local


def put(local: LocalGrid, x: float, y: float, log_odds: int) -> None:
    local.grid.log_odds[local.geometry.cell(x, y)] = log_odds


@settings(deadline=None, max_examples=50)
@given(st.lists(st.tuples(places, places), min_size=1, max_size=6))
def test_what_leaves_the_window_stays_in_its_place(ways: list[tuple[float, float]]) -> None:
    memory, marks = Recollection(), []
    for step, (x, y) in enumerate(ways):
        local = grid(Pose(x, y), 0, 0)
        mark = (floor(10.0 * x + 5.0) / 10.0 + 0.05, floor(10.0 * y - 7.0) / 10.0 + 0.05)
        put(local, *mark, 1500)
        marks.append(mark)
        memory.take(local, (1 + step) * SECOND)
        assert all(at(memory, *seen) > 0 for seen in marks)
    assert np.count_nonzero(memory.belief > 0) <= len(marks)
    assert not (memory.belief < 0).any()


def test_an_obstacle_is_one_from_the_limit_on() -> None:
    memory, local = Recollection(), grid(Pose(), 0, SECOND)
    put(local, 0.55, 0.05, 849)
    put(local, 0.75, 0.05, 850)
    memory.take(local, SECOND)
    assert (at(memory, 0.55, 0.05), at(memory, 0.75, 0.05) > 0) == (0, True)


def test_a_passer_by_is_forgotten_sooner_than_a_wall() -> None:
    memory = Recollection(remembering=Remembering(sighting=1, firmness=3))
    for step in range(10):
        local = grid(Pose(), -1000, SECOND)
        put(local, 0.55, 0.05, 1500)
        if step == 9:
            put(local, 0.75, 0.05, 1500)
        memory.take(local, SECOND)
    beliefs = []
    for _ in range(3):
        memory.take(grid(Pose(), -1000, SECOND), SECOND)
        beliefs.append((at(memory, 0.55, 0.05) > 0, at(memory, 0.75, 0.05) > 0))
    assert beliefs == [(True, False), (True, False), (False, False)]
    assert at(memory, 0.55, 0.05) == -1


def test_what_was_seen_free_long_ago_or_has_faded_takes_nothing_away() -> None:
    memory, local = Recollection(), grid(Pose(), 0, SECOND)
    put(local, 0.55, 0.05, 1500)
    memory.take(local, SECOND)
    for log_odds, seen_ns in ((-1000, SECOND), (0, 9 * SECOND), (-399, 9 * SECOND)):
        memory.take(grid(Pose(), log_odds, seen_ns), 9 * SECOND)
        assert at(memory, 0.55, 0.05) > 0


def test_a_finer_grid_shows_an_obstacle_if_any_of_its_cells_is_one_and_frees_only_if_all_are() -> None:
    memory = Recollection(remembering=Remembering(sighting=1))
    local = grid(Pose(), -1000, SECOND, resolution=0.05)
    put(local, 0.525, 0.025, 1500)
    memory.take(local, SECOND)
    assert at(memory, 0.55, 0.05) > 0
    put(local, 0.525, 0.025, -300)
    memory.take(local, SECOND)
    assert at(memory, 0.55, 0.05) > 0
    put(local, 0.525, 0.025, -1000)
    memory.take(local, SECOND)
    assert at(memory, 0.55, 0.05) == -1


def test_beneath_the_robot_is_no_obstacle() -> None:
    memory = Recollection()
    memory.take(grid(Pose(), 2000, SECOND), SECOND)
    memory.tread(0.0, 0.0, 0.2)
    free = memory.belief < 0
    x, y = np.meshgrid(memory.geometry.x_centres, memory.geometry.y_centres)
    assert np.array_equal(free, np.hypot(x, y) <= 0.2)


def test_relenting_forgets_what_is_not_seen_now_and_nothing_else() -> None:
    memory = Recollection()
    local = grid(Pose(), 0, SECOND)
    put(local, 0.55, 0.05, 1500)
    memory.take(local, SECOND)
    local = grid(Pose(), 0, SECOND)
    put(local, 0.75, 0.05, 1500)
    memory.take(local, SECOND)
    memory.relent()
    assert (at(memory, 0.55, 0.05), at(memory, 0.75, 0.05) > 0) == (0, True)


def test_what_is_far_from_the_robot_is_not_taken_over() -> None:
    memory = Recollection(remembering=Remembering(reach=1.0))
    memory.take(grid(Pose(0.05, 0.05), 2000, SECOND), SECOND)
    x, y = np.meshgrid(memory.geometry.x_centres, memory.geometry.y_centres)
    assert np.array_equal(memory.belief > 0, np.hypot(x - 0.05, y - 0.05) <= 1.0 + 1e-9)


NOWHERE = np.empty((0, 2))
numbers = st.integers(-150, 150)
dots = st.lists(st.tuples(numbers, numbers), min_size=1, max_size=12).map(
    lambda cells: np.array(cells) * 0.1 + 0.05
)
"""Middles of cells."""
seeds = st.integers(0, 2**32 - 1)


def speckled(robot: Pose, seed: int) -> LocalGrid:
    """Anything anywhere, seen lately or long ago."""
    local, rng = grid(robot, 0, 0), np.random.default_rng(seed)
    local.grid.log_odds[:] = rng.integers(-2000, 2001, local.grid.log_odds.shape)
    local.seen_ns[:] = rng.choice((0, 1, 9 * SECOND), local.seen_ns.shape)
    return local


@settings(max_examples=50)
@given(dots, dots)
def test_of_a_plan_the_walls_stand_the_floor_is_free_and_the_rest_is_unknown(
    walls: np.ndarray, free: np.ndarray
) -> None:
    memory = Recollection()
    memory.study(FloorPlan(walls, free))
    stands = {memory.geometry.cell(*point) for point in walls.tolist()}
    floor_cells = {memory.geometry.cell(*point) for point in free.tolist()} - stands
    assert {tuple(cell) for cell in np.argwhere(memory.belief > 0).tolist()} == stands
    assert {tuple(cell) for cell in np.argwhere(memory.belief < 0).tolist()} == floor_cells


@settings(max_examples=50)
@given(dots, st.lists(st.tuples(seeds, places, places, st.integers(0, 2)), min_size=1, max_size=6))
def test_walls_of_a_plan_are_never_forgotten(
    walls: np.ndarray, deeds: list[tuple[int, float, float, int]]
) -> None:
    memory = Recollection(remembering=Remembering(sighting=1, firmness=3))
    memory.study(FloorPlan(walls, NOWHERE))
    for seed, x, y, deed in deeds:
        if deed == 0:
            memory.take(grid(Pose(x, y), -2000, 9 * SECOND), 9 * SECOND)
            memory.take(speckled(Pose(x, y), seed), 9 * SECOND)
        elif deed == 1:
            memory.tread(*walls[seed % len(walls)].tolist(), 0.3)
        else:
            memory.relent()
        assert all(at(memory, *wall) == 3 for wall in walls.tolist())


def test_beside_a_wall_of_the_plan_the_local_grid_shows_the_wall_once_more() -> None:
    memory, local = Recollection(), grid(Pose(), 0, 0)
    memory.study(FloorPlan(np.array([(0.55, 0.05)]), NOWHERE))
    for x, y in ((0.45, 0.15), (0.65, 0.05), (0.55, -0.05), (0.35, 0.05), (0.75, 0.05)):
        put(local, x, y, 2000)
    memory.take(local, SECOND)
    assert [at(memory, x, y) for x, y in ((0.45, 0.15), (0.65, 0.05), (0.55, -0.05))] == [0, 0, 0]
    assert min(at(memory, 0.35, 0.05), at(memory, 0.75, 0.05)) > 0


@given(st.integers(1, 100), st.integers(0, 110))
def test_patience_is_how_many_takes_in_a_row_make_an_obstacle(patience: int, takes: int) -> None:
    memory, local = Recollection(remembering=Remembering(patience=patience)), grid(Pose(), 0, 0)
    put(local, 0.55, 0.05, 1500)
    for _ in range(takes):
        memory.take(local, SECOND)
    assert (at(memory, 0.55, 0.05) > 0) == (takes >= patience)


@given(st.lists(st.booleans(), max_size=30), st.integers(1, 5))
def test_who_steps_aside_in_between_has_not_stood_there(stood: list[bool], patience: int) -> None:
    memory, row, longest = Recollection(remembering=Remembering(patience=patience)), 0, 0
    for there in stood:
        local = grid(Pose(), 0, 0)
        put(local, 0.55, 0.05, 1500 if there else 0)
        memory.take(local, SECOND)
        row = row + 1 if there else 0
        longest = max(longest, row)
        assert (at(memory, 0.55, 0.05) > 0) == (longest >= patience)


@pytest.mark.parametrize("patience", [0, 101])
def test_a_patience_of_none_or_of_more_than_is_counted_is_refused(patience: int) -> None:
    with pytest.raises(ValueError, match=r"patience must lie in 1\.\.\.100"):
        Remembering(patience=patience)


@settings(max_examples=60)
@given(
    st.integers(0, 3),
    st.integers(-40, 40),
    st.integers(-40, 40),
    st.lists(st.tuples(seeds, st.floats(-4.0, 4.0), st.floats(-4.0, 4.0)), min_size=1, max_size=3),
)
def test_a_frame_that_is_turned_by_quarters_turns_the_memory(
    quarters: int, east: int, north: int, looks: list[tuple[int, float, float]]
) -> None:
    frame = Pose(east * 0.1, north * 0.1, quarters * pi / 2.0)
    plain, turned = Recollection(), Recollection()
    for seed, x, y in looks:
        local = speckled(Pose(x, y), seed)
        plain.take(local, 9 * SECOND)
        turned.take(local, 9 * SECOND, frame)
    assert np.count_nonzero(plain.belief > 0) == np.count_nonzero(turned.belief > 0)
    assert np.count_nonzero(plain.belief < 0) == np.count_nonzero(turned.belief < 0)
    for row, col in np.argwhere(plain.belief != 0).tolist():
        there = frame.compose(Pose(plain.geometry.x_centres[col], plain.geometry.y_centres[row]))
        assert at(turned, there.x, there.y) == plain.belief[row, col]


@settings(max_examples=60)
@given(places, places, st.floats(-20.0, 20.0), seeds)
def test_in_any_frame_an_obstacle_is_where_the_frame_puts_it(
    x: float, y: float, yaw: float, seed: int
) -> None:
    memory, local = Recollection(), grid(Pose(), 0, 0)
    rng = np.random.default_rng(seed)
    seen = [(float(a), float(b)) for a, b in rng.integers(-13, 13, (5, 2)) * 0.1 + 0.05]
    for place in seen:
        put(local, *place, 1500)
    memory.take(local, SECOND, Pose(x, y, yaw))
    c, s = cos(yaw), sin(yaw)
    placed = [(x + c * a - s * b, y + s * a + c * b) for a, b in seen]
    assume(all(abs(10.0 * each - round(10.0 * each)) > 1e-9 for place in placed for each in place))
    stands = {memory.geometry.cell(*place) for place in placed}
    assert {tuple(cell) for cell in np.argwhere(memory.belief > 0).tolist()} == stands


@settings(max_examples=60)
@given(places, places, st.floats(-20.0, 20.0))
def test_a_grid_that_is_half_as_coarse_leaves_no_cell_out_in_any_frame(
    x: float, y: float, yaw: float
) -> None:
    memory = Recollection()
    local = local_grid(80, 0.05)
    local.grid.log_odds[:], local.seen_ns[:] = -2000, SECOND
    memory.take(local, SECOND, Pose(x, y, yaw))
    east, north = np.meshgrid(memory.geometry.x_centres - x, memory.geometry.y_centres - y)
    assert (memory.belief[np.hypot(east, north) < 1.8] == -1).all()
