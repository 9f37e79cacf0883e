from math import cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.steering.obstacles import Belief, Obstacles, certainties
from echogrid.mapping.steering.window import Body, Window
from echogrid.mapping.unknown import Unknown

from .scenes import (
    BODY,
    CELLS,
    MIDDLE,
    NOW,
    RESOLUTION,
    WINDOW,
    Cell,
    cells,
    facing,
    headings,
    local_grid,
    view_of,
    within_cell,
    worlds,
)

SECOND = 1_000_000_000


@given(st.integers(-32768, 32767))
def test_a_certainty_lies_in_0_to_15_and_only_grows_with_the_evidence(milli: int) -> None:
    low, high = certainties(np.array([milli, min(milli + 1, 32767)], np.int16)).tolist()
    assert 0 <= low <= high <= 15
    assert (low == 15) == (milli >= 2000)
    assert low == 0 or milli > 0


@pytest.mark.parametrize(
    ("milli", "certainty"), [(0, 0), (133, 0), (134, 1), (800, 6), (1000, 7), (1999, 14)]
)
def test_certainties_are_even_steps_of_2_15_nats(milli: int, certainty: int) -> None:
    assert certainties(np.array([milli], np.int16)).tolist() == [certainty]


@given(st.lists(cells, max_size=25), st.integers(1, 15))
def test_the_obstacles_are_the_cells_that_are_certain_enough(world: list[Cell], least: int) -> None:
    view = view_of(world, belief=Belief(least=least))
    assert np.array_equal(view.hits, np.flatnonzero(view.certainty >= least))
    painted = {(row, col): milli for row, col, milli in world}
    expected = {
        (row, col)
        for (row, col), milli in painted.items()
        if hypot(row, col) <= 16.0 and milli * 15 // 2000 >= least
    }
    rows, cols = WINDOW.flat // CELLS - CELLS // 2, WINDOW.flat % CELLS - CELLS // 2
    assert {(int(rows[hit]), int(cols[hit])) for hit in view.hits} == expected


@given(st.lists(cells, max_size=10), within_cell, within_cell)
def test_the_robot_is_touched_by_what_is_within_it_to_the_millimetre(
    world: list[Cell], x: float, y: float
) -> None:
    view = view_of(world, facing(0.0, x, y))
    nearest = [
        0.0 if distance == 0.0 else hypot(east - x, north - y)
        for east, north, distance in zip(
            WINDOW.x[view.hits], WINDOW.y[view.hits], WINDOW.distance[view.hits], strict=True
        )
    ]
    assume(all(abs(distance - BODY.radius) > 1e-9 for distance in nearest))
    assert view.touching == (min(nearest, default=1.0) < BODY.radius)


@given(worlds, headings, within_cell, within_cell)
def test_up_to_its_clearance_the_disc_touches_nothing_and_beyond_it_does(
    world: list[Cell], heading: float, x: float, y: float
) -> None:
    view = view_of(world, facing(0.0, x, y))
    assume(not view.touching)
    clearance = view.clearance(heading)
    assert 0.0 <= clearance <= WINDOW.horizon
    east, north = WINDOW.x[view.hits] - x, WINDOW.y[view.hits] - y

    def nearest(way: float) -> float:
        gaps = np.hypot(east - way * cos(heading), north - way * sin(heading))
        return float(gaps.min(initial=9.0))

    assert min(nearest(way) for way in np.linspace(0.0, clearance, 30)) >= BODY.radius - 1e-6
    if clearance < WINDOW.horizon:
        assert nearest(clearance + 1e-4) < BODY.radius + 1e-6


def test_the_view_s_arrays_are_its_own() -> None:
    local, obstacles = local_grid([(0, 5, 2000)]), Obstacles(WINDOW)
    view = obstacles.view(local, MIDDLE, NOW)
    before = view.hits.tolist(), view.certainty.tolist(), view.seen_ns.tolist()
    local.grid.log_odds[:] = 0
    local.seen_ns[:] = 0
    obstacles.view(local, MIDDLE, NOW)
    assert (view.hits.tolist(), view.certainty.tolist(), view.seen_ns.tolist()) == before


@pytest.mark.parametrize("seen_ns", [0, NOW - SECOND])
def test_what_was_never_seen_or_not_lately_is_not_known(seen_ns: int) -> None:
    view = Obstacles(WINDOW).view(local_grid([], seen_ns), MIDDLE, NOW)
    assert view.known.tolist() == [0.0] * 72
    assert not view.shut.any()


def test_at_the_clock_s_beginning_the_unseen_is_not_known_either() -> None:
    view = Obstacles(WINDOW).view(local_grid([], 0), MIDDLE, 1000)
    assert view.known.tolist() == [0.0] * 72


@given(st.integers(0, 71), st.integers(8, 20))
def test_a_wedge_that_is_not_known_is_shut_in_its_midst_and_nothing_else_is(sector: int, half: int) -> None:
    local = local_grid([])
    turns = (WINDOW.nearest_sector - sector + 36) % 72 - 36
    local.seen_ns.ravel()[WINDOW.flat[np.abs(turns) <= half]] = 0
    view = Obstacles(WINDOW, Belief(Unknown.BLOCKED)).view(local, MIDDLE, NOW)
    off = np.abs((np.arange(72) - sector + 36) % 72 - 36)
    assert view.shut[off <= half - 2].all()
    assert not view.shut[off > half + 2].any()


def test_narrow_gaps_between_the_rangers_do_not_make_a_direction_unknown() -> None:
    """Sixteen cones of 16 deg, 22.5 deg apart, seen from the rim of the robot."""
    local = LocalGrid(0.05, 120, 0.1, 15.0, NoEcho.WEAK)
    local.centre(MIDDLE)
    for number in range(16):
        seat = MIDDLE.compose(Pose(0.0, 0.0, number * pi / 8.0)).compose(Pose(0.15))
        local.fuse(seat, Ranger("sonar", Pose(), 0.14, 0.0, 4.0), 2.5, NOW)
    window = Window(0.05, 120, Body(), 1.65)
    view = Obstacles(window, Belief(Unknown.BLOCKED)).view(local, MIDDLE, NOW)
    assert view.known.min() > 0.9
    assert not view.shut.any()


@given(headings, st.floats(0.0, 1.0), within_cell, within_cell)
def test_a_way_is_free_if_all_was_seen_free(heading: float, way: float, x: float, y: float) -> None:
    assert view_of([], facing(0.0, x, y)).free(heading, way)


@given(headings, st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(-1.0, 1.0), st.booleans())
def test_no_way_is_free_that_comes_to_a_cell_which_was_not_seen_free(
    heading: float, way: float, part: float, aside: float, seen: bool
) -> None:
    """The cell is on the strip that the disc sweeps, and not within the robot already."""
    along, across = BODY.radius + part * way, aside * BODY.radius * 0.99
    gone = max(along - BODY.radius * 2.0, 0.0)
    x = cos(heading) * along - sin(heading) * across
    y = sin(heading) * along + cos(heading) * across
    col, row = round(x / RESOLUTION), round(y / RESOLUTION)
    centre = col * RESOLUTION, row * RESOLUTION
    forth = centre[0] * cos(heading) + centre[1] * sin(heading)
    beside = centre[1] * cos(heading) - centre[0] * sin(heading)
    assume(gone <= way and hypot(*centre) > BODY.radius + 1e-9 and forth > 1e-9)
    assume(hypot(max(forth - way, 0.0), beside) < BODY.radius)
    local = local_grid([(row, col, 0)])
    if not seen:
        local.grid.log_odds[:] = -2000
        local.seen_ns[CELLS // 2 + row, CELLS // 2 + col] = 0
    assert not Obstacles(WINDOW).view(local, MIDDLE, NOW).free(heading, way)


def test_no_way_out_of_the_window_is_free() -> None:
    assert view_of([]).free(0.0, 1.3)
    assert not view_of([]).free(0.0, 1.5)


def test_the_robot_s_place_in_its_cell_is_told_from_the_middle() -> None:
    local = LocalGrid(RESOLUTION, CELLS, 0.1, 10.0, NoEcho.WEAK)
    robot = Pose(12.34, -5.67, 1.0)
    local.centre(robot)
    assert Obstacles(WINDOW).view(local, robot, NOW).offset == approx((-0.01, -0.02))


@pytest.mark.parametrize("belief", [{"least": 0}, {"least": 16}, {"known": 0.0}, {"known": 1.1}])
def test_an_impossible_belief_is_refused(belief: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must lie in"):
        Belief(**belief)


@given(
    worlds,
    within_cell,
    within_cell,
    st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)), min_size=1, max_size=5),
    st.floats(0.0, 0.2),
)
def test_the_robot_fits_to_a_point_if_no_obstacle_ahead_is_too_near_to_the_straight_way(
    world: list[Cell], x: float, y: float, points: list[tuple[float, float]], margin: float
) -> None:
    robot = facing(0.3, x, y)
    view = view_of(world, robot)
    expected = []
    for to_x, to_y in points:
        dx, dy = to_x - robot.x, to_y - robot.y
        length, fits = max(hypot(dx, dy), 1e-9), True
        for n in view.hits.tolist():
            at_x, at_y = WINDOW.x[n] - x, WINDOW.y[n] - y
            along = (at_x * dx + at_y * dy) / length
            away = hypot(at_x - min(along, length) * dx / length, at_y - min(along, length) * dy / length)
            keep = BODY.radius + margin + RESOLUTION / 2.0**0.5
            assume(abs(along) > 1e-9 and abs(away - keep) > 1e-9)
            fits = fits and not (along > 0.0 and away < keep)
        expected.append(fits)
    assert view.fits(np.array(points), margin).tolist() == expected


@given(
    worlds, st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)), st.floats(0.0, 0.3), st.floats(0.0, 0.3)
)
def test_who_fits_with_a_margin_fits_with_less(
    world: list[Cell], point: tuple[float, float], one: float, other: float
) -> None:
    view, (less, more) = view_of(world), sorted((one, other))
    assert view.fits(np.array([point]), less) >= view.fits(np.array([point]), more)
