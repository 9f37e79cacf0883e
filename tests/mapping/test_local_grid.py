from math import exp, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.cone import cast
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.virtual_sensor import SectorState, Sight, VirtualSensor

from .strategies import poses

MS = 1_000_000
SECOND = 1000 * MS
RESOLUTION = 0.1
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.0, 4.0)
sizes = st.integers(9, 41)
places = st.integers(-500, 500)
insides = st.floats(0.001, 0.999)


def local_grid(cells: int = 60, fade_s: float = 10.0, no_echo: NoEcho = NoEcho.WEAK) -> LocalGrid:
    return LocalGrid(RESOLUTION, cells, 0.1, fade_s, no_echo)


def contents(local: LocalGrid) -> dict[tuple[int, int], tuple[int, int, bool]]:
    """What each place of the world holds; places are numbered from the origin of the odom frame."""
    geometry, grid = local.geometry, local.grid
    first_row, first_col = geometry.y / RESOLUTION, geometry.x / RESOLUTION
    assert first_row == approx(round(first_row), abs=1e-6)
    assert first_col == approx(round(first_col), abs=1e-6)
    return {
        (round(first_row) + row, round(first_col) + col): (
            int(grid.log_odds[row, col]),
            int(local.seen_ns[row, col]),
            bool(grid.unknown()[row, col]),
        )
        for row in range(geometry.rows)
        for col in range(geometry.cols)
    }


@settings(deadline=None)
@given(sizes, st.lists(poses(3.0), min_size=1, max_size=6), st.floats(0.2, 2.0))
def test_what_stays_in_the_window_stays_in_its_place_and_what_leaves_is_forgotten(
    cells: int, ways: list[Pose], echo: float
) -> None:
    local = local_grid(cells)
    for n, robot in enumerate(ways):
        before = contents(local)
        local.centre(robot)
        for place, content in contents(local).items():
            assert content == before.get(place, (0, 0, True))
        local.fuse(robot, SONAR, echo, n + 1)


@given(sizes, st.lists(st.tuples(places, places, insides, insides), min_size=1, max_size=5))
def test_the_robot_is_in_the_middle_cell(cells: int, ways: list[tuple[int, int, float, float]]) -> None:
    local = local_grid(cells)
    for col, row, right, up in ways:
        robot = Pose((col + right) * RESOLUTION, (row + up) * RESOLUTION)
        local.centre(robot)
        assert local.geometry.cell(robot.x, robot.y) == (cells // 2, cells // 2)


def test_a_robot_that_stays_in_its_cell_moves_nothing() -> None:
    local = local_grid()
    geometry = local.geometry
    local.centre(Pose(0.099, 0.001))
    assert local.geometry is geometry


def test_a_robot_that_was_carried_away_sees_nothing_of_before() -> None:
    local = local_grid()
    local.fuse(Pose(), SONAR, 1.0, 1)
    local.centre(Pose(100.0, -100.0))
    assert local.grid.unknown().all()
    assert not local.seen_ns.any()


@given(st.lists(st.integers(0, 2000), max_size=50))
def test_evidence_fades_with_its_time_constant(pauses_ms: list[int]) -> None:
    local = local_grid(9)
    local.fade(0)
    local.grid.log_odds[4, 4] = 2000
    now_ns = 0
    for pause_ms in pauses_ms:
        now_ns += pause_ms * MS
        local.fade(now_ns)
    steps = now_ns / (250 * MS) + 1
    due = 2000 * exp(-now_ns * 1e-9 / 10.0)
    overdue = 2000 * exp(-max(now_ns * 1e-9 - 0.25, 0.0) / 10.0)
    assert due - steps <= local.grid.log_odds[4, 4] <= overdue + 1e-6


def test_the_first_tick_fades_nothing() -> None:
    local = local_grid(9)
    local.grid.log_odds[:] = 2000
    local.fade(3600 * SECOND)
    assert np.all(local.grid.log_odds == 2000)


def test_only_cells_of_which_a_ping_spoke_count_as_seen() -> None:
    local = local_grid(cells=90)
    local.fuse(Pose(), SONAR, None, SECOND)
    assert np.array_equal(local.seen_ns > 0, ~local.grid.unknown())
    cone = cast(local.geometry, Sounding(Pose(), SONAR, None, 0.1))
    silent = (cone.bearing > radians(8.0)) | (cone.distance > 2.4)
    assert not local.seen_ns[cone.rows[silent], cone.cols[silent]].any()
    assert local.seen_ns.any()


def test_silence_that_is_to_be_ignored_makes_nothing_seen() -> None:
    local = local_grid(no_echo=NoEcho.IGNORE)
    local.fuse(Pose(), SONAR, None, SECOND)
    assert not local.seen_ns.any()


def test_a_ping_that_arrives_after_a_later_one_makes_nothing_older() -> None:
    local = local_grid()
    local.fuse(Pose(), SONAR, 1.0, 2 * SECOND)
    local.fuse(Pose(), SONAR, 1.0, SECOND)
    assert set(np.unique(local.seen_ns)) == {0, 2 * SECOND}


def test_a_few_contrary_pings_turn_a_cell_over() -> None:
    local = local_grid()
    for _ in range(1000):
        local.fuse(Pose(0.0, 0.05), SONAR, 1.0, 1)
    cell = local.geometry.cell(1.05, 0.05)
    assert local.grid.log_odds[cell] == 2000
    for _ in range(4):
        local.fuse(Pose(0.0, 0.05), SONAR, 2.0, 1)
    assert local.grid.log_odds[cell] < 0


@settings(deadline=None, max_examples=50)
@given(st.floats(0.3, 1.9), st.floats(0.5, 2.0), st.floats(-3.0, 3.0), st.integers(1, 100))
@pytest.mark.parametrize("no_echo", NoEcho)
def test_a_removed_obstacle_that_is_seen_again_as_free_at_10_hz_is_gone_within_2_s(
    no_echo: NoEcho, obstacle: float, behind: float, yaw: float, echoes: int
) -> None:
    local, robot = local_grid(no_echo=no_echo), Pose(0.03, 0.07, yaw)
    sensor = VirtualSensor(Sight(horizon=2.0), RESOLUTION, 60)
    now_ns = SECOND
    for _ in range(echoes):
        now_ns += 100 * MS
        local.fade(now_ns)
        local.fuse(robot, SONAR, obstacle, now_ns)
    for _ in range(20):
        now_ns += 100 * MS
        local.fade(now_ns)
        local.fuse(robot, SONAR, obstacle + behind, now_ns)
    near = [s for s in sensor.view(local, robot, now_ns).sectors if s.nearest < obstacle + 0.2]
    assert not near


@settings(deadline=None, max_examples=50)
@given(st.floats(0.3, 1.5), st.floats(-3.0, 3.0), st.sampled_from([1.0, None]))
def test_cells_of_a_removed_obstacle_that_was_surely_there_are_free_within_2_s(
    obstacle: float, yaw: float, behind: float | None
) -> None:
    """By 20 echoes from behind it or, near the axis, by as many silences."""
    local, robot = local_grid(), Pose(0.03, 0.07, yaw)
    for _ in range(300):
        local.fuse(robot, SONAR, obstacle, SECOND)
    cone = cast(local.geometry, Sounding(robot, SONAR, obstacle, 0.1))
    gone = cone.occupied if behind else cone.occupied & (cone.bearing < radians(3.0))
    cells = cone.rows[gone], cone.cols[gone]
    assert np.all(local.grid.occupancy()[cells] > 0.85)
    for _ in range(20):
        local.fuse(robot, SONAR, obstacle + behind if behind else None, SECOND)
    assert np.all(local.grid.occupancy()[cells] < 0.5)


def test_an_obstacle_is_seen_in_its_sector_at_its_distance() -> None:
    local, robot = local_grid(), Pose(0.05, 0.05, 0.0)
    local.fuse(robot, SONAR, 1.0, SECOND)
    local.fuse(robot, SONAR, 1.0, SECOND)
    view = VirtualSensor(Sight(), RESOLUTION, 60).view(local, robot, SECOND)
    assert view.sectors[0].state is SectorState.BLOCKED
    assert view.sectors[0].nearest == approx(1.0, abs=0.11)


@settings(deadline=None)
@given(poses(1.0), st.floats(0.3, 2.0), st.integers(1, 20))
def test_the_echo_of_a_known_wall_leaves_no_obstacle_and_frees_what_is_before_it(
    robot: Pose, echo: float, echoes: int
) -> None:
    known, strange = local_grid(), local_grid()
    for local in (known, strange):
        local.centre(robot)
        for n in range(echoes):
            local.fuse(robot, SONAR, echo, SECOND + n, known=local is known)
    cone = cast(known.geometry, Sounding(robot, SONAR, echo, 0.1))
    assert not (known.grid.log_odds > 0).any()
    assert not known.grid.log_odds.ravel()[cone.cells[cone.occupied]].any()
    before = cone.cells[~cone.occupied]
    assert np.array_equal(known.grid.log_odds.ravel()[before], strange.grid.log_odds.ravel()[before])


def test_what_stands_before_a_known_wall_is_taken_away_by_its_echo_and_the_wall_is_not() -> None:
    local, robot = local_grid(), Pose(0.05, 0.05)
    for _ in range(3):
        local.fuse(robot, SONAR, 1.0, SECOND)
    local.build(np.array([(2.05, 0.05)]), SECOND)
    before, wall = local.geometry.cell(1.05, 0.05), local.geometry.cell(2.05, 0.05)
    assert local.grid.log_odds[before] > 850
    for _ in range(10):
        local.fuse(robot, SONAR, 2.0, SECOND, known=True)
    assert local.grid.log_odds[before] < 0
    assert local.grid.log_odds[wall] == 2000


@settings(deadline=None)
@given(
    poses(3.0),
    st.lists(st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0)), max_size=30),
    st.none() | st.floats(0.2, 3.0),
)
def test_built_walls_are_fresh_obstacles_and_nothing_else_becomes_one(
    robot: Pose, walls: list[tuple[float, float]], echo: float | None
) -> None:
    local = local_grid()
    local.centre(robot)
    local.fuse(robot, SONAR, echo, SECOND)
    odds, seen_ns = local.grid.log_odds.copy(), local.seen_ns.copy()
    local.build(np.array(walls).reshape(-1, 2), 5 * SECOND)
    cells = {
        local.geometry.cell(x, y) for x, y in walls if local.geometry.contains(*local.geometry.cell(x, y))
    }
    for cell in cells:
        odds[cell], seen_ns[cell] = 2000, 5 * SECOND
    assert np.array_equal(local.grid.log_odds, odds)
    assert np.array_equal(local.seen_ns, seen_ns)


@given(st.lists(st.integers(0, 59 * 60 + 59), max_size=40, unique=True), st.integers(0, 2**32 - 1))
def test_vacated_cells_are_no_obstacles_and_keep_what_freed_them(cells: list[int], seed: int) -> None:
    local = local_grid()
    local.grid.log_odds[:] = np.random.default_rng(seed).integers(-2000, 2001, (60, 60))
    expected = local.grid.log_odds.ravel().tolist()
    local.vacate(np.array(cells, np.intp))
    for cell in cells:
        expected[cell] = min(expected[cell], 0)
    assert local.grid.log_odds.ravel().tolist() == expected


def test_pings_that_wait_are_fused_before_walls_are_built_or_cells_vacated() -> None:
    local, robot = local_grid(), Pose(0.05, 0.05)
    cell = local.geometry.cell(1.05, 0.05)
    for _ in range(3):
        local.fuse(robot, SONAR, 1.0, SECOND)
    local.vacate(np.array([cell[0] * 60 + cell[1]]))
    assert local.grid.log_odds[cell] == 0
    for _ in range(5):
        local.fuse(robot, SONAR, 2.0, SECOND)
    local.build(np.array([(1.05, 0.05)]), SECOND)
    assert local.grid.log_odds[cell] == 2000
