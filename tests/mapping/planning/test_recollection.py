from math import floor

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping.local_grid import LocalGrid
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
