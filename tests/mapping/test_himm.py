from math import cos, pi, radians, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.himm import HimmGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.ray import cross
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.sounding import Sounding

from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-2.0, -2.0, 2.0, 2.0, 0.2)
BOOK = GridGeometry(0.1, 0.0, 0.0, 5, 5)
BOOK_HITS = [(2, 0), (2, 0), (2, 1), (2, 1), (1, 0), (1, 1), (1, 2), (0, 2)]
"""Rows from the top; the robot is below, and looks up each column."""
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.0, 4.0)

pings = st.tuples(poses(2.0), rangers(0.05), st.none() | st.floats(0.0, 4.0))
many_pings = st.lists(pings, max_size=8)


def by_hand(many: list[tuple[Pose, Ranger, float | None]], clears: bool, growth: bool) -> list[list[int]]:
    """The counts, cell by cell."""
    counts = [[0] * GEOMETRY.cols for _ in range(GEOMETRY.rows)]
    for seat, ranger, echo in many:
        if echo is None and not clears:
            continue
        length = ranger.farthest if echo is None else echo
        end = GEOMETRY.cell(seat.x + length * cos(seat.yaw), seat.y + length * sin(seat.yaw))
        ray = cross(GEOMETRY, seat, length)
        for row, col in zip(ray.rows.tolist(), ray.cols.tolist(), strict=True):
            if echo is None or (row, col) != end:
                counts[row][col] = max(counts[row][col] - 1, 0)
        if echo is not None and GEOMETRY.contains(*end):
            row, col = end
            beside = [
                counts[r][c]
                for r in range(row - 1, row + 2)
                for c in range(col - 1, col + 2)
                if (r, c) != end and GEOMETRY.contains(r, c)
            ]
            risen = counts[row][col] + 3 + (sum(beside) * 0.5 if growth else 0.0)
            counts[row][col] = min(int(risen), 15)
    return counts


@settings(deadline=None)
@given(many_pings, st.booleans(), st.booleans())
def test_the_counts_are_those_of_the_equations_cell_by_cell(many, clears: bool, growth: bool) -> None:
    grid = HimmGrid(GEOMETRY, NoEcho.CLEAR if clears else NoEcho.IGNORE, growth)
    for ping in many:
        grid.update(Sounding(*ping, 0.1))
    assert grid.counts.tolist() == by_hand(many, clears, growth)


@settings(deadline=None)
@given(pings, st.booleans())
def test_a_ping_speaks_only_of_its_axis_and_only_within_its_patch(ping, clears: bool) -> None:
    grid = HimmGrid(GEOMETRY, NoEcho.CLEAR if clears else NoEcho.IGNORE)
    patch = grid.update(Sounding(*ping, 0.1))
    known = ~grid.unknown()
    assert (patch is None) == (not known.any())
    seat = ping[0]
    for row, col in np.argwhere(known):
        dx, dy = GEOMETRY.x_centres[col] - seat.x, GEOMETRY.y_centres[row] - seat.y
        across = abs(cos(seat.yaw) * dy - sin(seat.yaw) * dx)
        assert across <= GEOMETRY.resolution * 0.5**0.5 + 1e-6
    if patch is not None:
        known[patch] = False
    assert not known.any()


@settings(deadline=None)
@given(many_pings)
def test_occupancy_is_a_number_from_0_to_1_and_one_half_where_unknown(many) -> None:
    grid = HimmGrid(GEOMETRY)
    for ping in many:
        grid.update(Sounding(*ping, 0.1))
    occupancy = grid.occupancy()
    assert np.all((occupancy >= 0.0) & (occupancy <= 1.0))
    assert np.all(occupancy[grid.unknown()] == 0.5)


def looked_up(hits: list[tuple[int, int]], growth: bool) -> tuple[HimmGrid, list[int]]:
    """The book's grid, and what each hit cell came to."""
    grid, risen = HimmGrid(BOOK, growth=growth), []
    for row, col in hits:
        seat = Pose((col + 0.5) * 0.1, 0.05, pi / 2.0)
        grid.update(Sounding(seat, SONAR, (4 - row) * 0.1, 0.1))
        risen.append(int(grid.counts[4 - row, col]))
    return grid, risen


def test_figure_11_11() -> None:
    grid, _ = looked_up(BOOK_HITS, growth=False)
    assert grid.counts[::-1][:3, :3].tolist() == [[0, 0, 3], [3, 3, 2], [5, 5, 0]]


def test_the_growth_rate_operator_lets_a_wall_grow_faster() -> None:
    grid, risen = looked_up(BOOK_HITS, growth=True)
    assert risen == [3, 6, 6, 12, 11, 15, 15, 15]
    assert grid.counts[::-1][:3, :3].tolist() == [[0, 0, 15], [11, 15, 14], [5, 11, 0]]


@pytest.mark.parametrize("growth", [False, True])
def test_five_hits_fill_a_cell_and_fifteen_misses_empty_it_and_nothing_runs_over(growth: bool) -> None:
    grid, cell = HimmGrid(GEOMETRY, growth=growth), GEOMETRY.cell(0.1, 0.1)
    at, beyond = (Sounding(Pose(-1.9, 0.1), SONAR, echo, 0.1) for echo in (2.0, 3.0))
    for _ in range(4):
        grid.update(at)
    assert grid.counts[cell] == 12
    for _ in range(50):
        grid.update(at)
    assert grid.counts[cell] == 15
    misses = 0
    while grid.occupancy()[cell] > 0.5:
        grid.update(beyond)
        misses += 1
    assert misses == 8
    for _ in range(50):
        grid.update(beyond)
    assert grid.counts[cell] == 0
    for _ in range(3):
        grid.update(at)
    assert grid.occupancy()[cell] > 0.5


@pytest.mark.parametrize("no_echo", [NoEcho.IGNORE, NoEcho.WEAK])
def test_silence_is_ignored(no_echo: NoEcho) -> None:
    grid = HimmGrid(GEOMETRY, no_echo)
    assert grid.update(Sounding(Pose(), SONAR, None, 0.1)) is None
    assert grid.unknown().all()


def test_silence_may_be_told_to_clear_the_axis_to_the_reach() -> None:
    grid = HimmGrid(GEOMETRY, NoEcho.CLEAR)
    grid.counts[:] = 9
    grid.update(Sounding(Pose(-1.9, 0.1), Ranger("sonar", Pose(), 0.3, 0.0, 3.0), None, 0.1))
    assert grid.counts[10].tolist() == [8] * 16 + [9] * 4
    assert np.all(np.delete(grid.counts, 10, axis=0) == 9)


def test_a_copy_goes_its_own_way() -> None:
    grid = HimmGrid(GEOMETRY, NoEcho.CLEAR, growth=True)
    twin = grid.copy()
    for echo in (1.0, 1.0, None):
        twin.update(Sounding(Pose(), SONAR, echo, 0.1))
    assert not grid.counts.any()
    assert grid.unknown().all()
    assert twin.counts.any()
    assert not twin.unknown()[10, 19]
