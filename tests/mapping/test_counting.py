from math import exp, radians

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.counting import FULL, CountingGrid, reflection
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sounding import Sounding

from .by_hand import Cell
from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-2.0, -2.0, 2.0, 2.0, 0.2)
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.0, 4.0)
AT, BEYOND = (Sounding(Pose(-1.9, 0.1), SONAR, echo, 0.1) for echo in (2.0, 3.0))
CELL = GEOMETRY.cell(0.1, 0.1)

pings = st.tuples(poses(2.0), rangers(0.05), st.none() | st.floats(0.0, 4.0))
many_pings = st.lists(pings, min_size=1, max_size=5)


@settings(deadline=None)
@given(many_pings)
def test_an_update_is_that_of_the_equations_cell_by_cell(
    many: list[tuple[Pose, Ranger, float | None]],
) -> None:
    grid = CountingGrid(GEOMETRY)
    for ping in many:
        grid.update(Sounding(*ping, 0.1))
    for row, y in enumerate(GEOMETRY.y_centres):
        for col, x in enumerate(GEOMETRY.x_centres):
            cells = [Cell(float(x), float(y), ping, GEOMETRY.resolution) for ping in many]
            if any(cell.on_a_border() for cell in cells):
                continue
            sums = {1: 0.0, 2: 0.0, 3: 0.0}
            for cell in cells:
                if cell.echo is not None:
                    sums[cell.region()] += exp(-2.0 * (cell.alpha / radians(8.0)) ** 2) / max(cell.r, 0.3)
            rounding = 0.5 * len(many) + 1e-6
            assert abs(grid.hits[row, col] - 1000.0 * sums[1]) <= rounding
            assert abs(grid.misses[row, col] - 1000.0 * sums[2]) <= rounding


@settings(deadline=None)
@given(many_pings.flatmap(lambda many: st.tuples(st.just(many), st.permutations(many))))
def test_the_order_of_the_pings_does_not_change_a_bit(orders) -> None:
    first, second = CountingGrid(GEOMETRY), CountingGrid(GEOMETRY)
    for ping, other in zip(*orders, strict=True):
        first.update(Sounding(*ping, 0.1))
        second.update(Sounding(*other, 0.1))
    assert first.occupancy().tobytes() == second.occupancy().tobytes()
    assert np.array_equal(first.unknown(), second.unknown())


@settings(deadline=None)
@given(pings)
def test_a_ping_speaks_only_of_its_patch(ping: tuple[Pose, Ranger, float | None]) -> None:
    grid = CountingGrid(GEOMETRY)
    patch = grid.update(Sounding(*ping, 0.1))
    known = ~grid.unknown()
    assert (patch is None) == (not known.any())
    if patch is not None:
        known[patch] = False
    assert not known.any()


@given(st.integers(0, FULL), st.integers(0, FULL))
def test_no_count_is_certain_and_none_is_absorbed(hits: int, misses: int) -> None:
    grid = CountingGrid(GEOMETRY)
    grid.hits[:], grid.misses[:] = hits, misses
    assert np.all((grid.occupancy() >= 0.0) & (grid.occupancy() <= 1.0))
    assert 0.0 < reflection(np.float64(hits / 1000.0), np.float64(misses / 1000.0)) < 1.0


def test_two_and_a_half_hits_and_four_fifths_of_a_miss() -> None:
    assert reflection(np.float64(2.5), np.float64(0.8)) == approx(0.7285714, abs=1e-6)


def test_with_nothing_heard_one_cell_in_four_is_occupied_but_unknown_is_one_half() -> None:
    assert reflection(np.float64(0.0), np.float64(0.0)) == approx(0.25)
    assert np.all(CountingGrid(GEOMETRY).occupancy() == 0.5)


def test_silence_is_ignored() -> None:
    grid = CountingGrid(GEOMETRY)
    assert grid.update(Sounding(Pose(), SONAR, None, 0.1)) is None
    assert grid.unknown().all()


def test_as_many_misses_as_there_were_hits_lead_across_one_half() -> None:
    grid = CountingGrid(GEOMETRY)
    for _ in range(100):
        grid.update(AT)
    assert grid.occupancy()[CELL] > 0.99
    for _ in range(101):
        grid.update(BEYOND)
    assert grid.occupancy()[CELL] < 0.5


def test_a_full_cell_keeps_its_mind_but_can_still_change_it() -> None:
    grid = CountingGrid(GEOMETRY)
    for here, there, ping in ((grid.hits, grid.misses, BEYOND), (grid.misses, grid.hits, AT)):
        here[CELL], there[CELL] = FULL // 2, FULL // 2 - 10
        before = grid.occupancy()[CELL]
        grid.update(ping)
        assert grid.occupancy()[CELL] == approx(before, abs=1e-6)
        assert 0 < here[CELL] < there[CELL] <= FULL // 2
        here[CELL], there[CELL] = FULL, 0
        grid.update(ping)
        assert here[CELL] == FULL // 2


def test_a_copy_goes_its_own_way() -> None:
    grid = CountingGrid(GEOMETRY)
    twin = grid.copy()
    twin.update(AT)
    assert grid.unknown().all()
    assert not twin.unknown()[CELL]
