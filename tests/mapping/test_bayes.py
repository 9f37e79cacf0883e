from math import ceil, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.bayes import BayesGrid, probability
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import Form, NoEcho
from echogrid.mapping.sounding import Sounding

from .by_hand import Cell
from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-2.0, -2.0, 2.0, 2.0, 0.2)
FAR_LIMIT = 32.0
"""nats: no four pings get there."""

forms = st.sampled_from(Form)
silences = st.sampled_from(NoEcho)
echoes = st.none() | st.floats(0.0, 4.0)
pings = st.tuples(poses(2.0), rangers(0.05), echoes)


def sounding_of(ping: tuple[Pose, Ranger, float | None]) -> Sounding:
    return Sounding(*ping, 0.1)


def grid_of(
    form: Form = Form.CONSISTENT, no_echo: NoEcho = NoEcho.WEAK, limit: float = FAR_LIMIT
) -> BayesGrid:
    return BayesGrid(GEOMETRY, limit, form, no_echo)


@settings(deadline=None)
@given(pings, forms, silences)
def test_an_update_is_that_of_the_equations_cell_by_cell(
    ping: tuple[Pose, Ranger, float | None], form: Form, no_echo: NoEcho
) -> None:
    grid = grid_of(form, no_echo)
    grid.update(sounding_of(ping))
    for row, y in enumerate(GEOMETRY.y_centres):
        for col, x in enumerate(GEOMETRY.x_centres):
            cell = Cell(float(x), float(y), ping, GEOMETRY.resolution)
            if not cell.on_a_border():
                expected = 1000.0 * cell.likelihood_ratio(form, no_echo)
                assert abs(grid.log_odds[row, col] - expected) <= 0.5 + 1e-3
                assert cell.region() != 3 or grid.unknown()[row, col]


@settings(deadline=None)
@given(pings, forms, silences)
def test_a_ping_speaks_only_of_its_patch(
    ping: tuple[Pose, Ranger, float | None], form: Form, no_echo: NoEcho
) -> None:
    grid = grid_of(form, no_echo)
    patch = grid.update(sounding_of(ping))
    if patch is not None:
        grid.log_odds[patch] = 0
    assert not grid.log_odds.any()


@settings(deadline=None)
@given(
    st.lists(pings, min_size=2, max_size=4).flatmap(
        lambda many: st.tuples(st.just(many), st.permutations(many))
    )
)
def test_below_the_clamp_the_order_of_the_pings_does_not_matter(orders) -> None:
    first, second = grid_of(), grid_of()
    for ping, other in zip(*orders, strict=True):
        first.update(sounding_of(ping))
        second.update(sounding_of(other))
    assert np.array_equal(first.log_odds, second.log_odds)
    assert np.array_equal(first.unknown(), second.unknown())


@settings(deadline=None)
@given(st.lists(pings, max_size=6), forms, silences, st.floats(0.1, 5.0))
def test_log_odds_stay_within_the_clamp_and_probabilities_are_numbers_between_0_and_1(
    many, form: Form, no_echo: NoEcho, limit: float
) -> None:
    grid = grid_of(form, no_echo, limit)
    for ping in many:
        grid.update(sounding_of(ping))
    assert np.all(np.abs(grid.log_odds) <= round(limit * 1000.0))
    occupancy = grid.occupancy()
    assert np.all((occupancy > 0.0) & (occupancy < 1.0))
    assert np.all(occupancy[grid.unknown()] == 0.5)


@settings(deadline=None)
@given(st.integers(1, 200), st.sampled_from([2.0, 4.6]))
def test_the_clamp_never_absorbs(echoes_before: int, limit: float) -> None:
    ranger = Ranger("sonar", Pose(), radians(15.0), 0.0, 4.0)
    seat, cell = Pose(-1.9, 0.1), (10, 15)
    grid = grid_of(limit=limit)
    at_cell, beyond = Sounding(seat, ranger, 3.0, 0.1), Sounding(seat, ranger, 3.8, 0.1)
    for _ in range(echoes_before):
        grid.update(at_cell)
    before = int(grid.log_odds[cell])
    assert before > 0
    grid.update(beyond)
    step = before - int(grid.log_odds[cell])
    for _ in range(ceil(limit * 1000.0 / step)):
        grid.update(beyond)
    assert grid.log_odds[cell] < 0


def test_from_a_certainty_of_0_the_grid_comes_back() -> None:
    ranger = Ranger("sonar", Pose(), radians(15.0), 0.0, 4.0)
    grid = grid_of(limit=6.9)
    grid.log_odds[:] = -6900
    for _ in range(10):
        grid.update(Sounding(Pose(-1.9, 0.1), ranger, 1.0, 0.1))
    assert grid.occupancy()[10, 5] > 0.5


def test_a_ping_that_says_nothing_touches_nothing() -> None:
    grid = grid_of(no_echo=NoEcho.IGNORE)
    assert grid.update(sounding_of((Pose(), Ranger("sonar", Pose(), 0.3, 0.0, 4.0), None))) is None
    assert grid.unknown().all()


def test_a_ping_from_outside_the_grid_touches_nothing() -> None:
    grid = grid_of()
    assert grid.update(sounding_of((Pose(50.0, 50.0), Ranger("sonar", Pose(), 0.3, 0.0, 4.0), 1.0))) is None


@given(st.floats(0.0, 1.0))
def test_fading_brings_every_cell_nearer_to_nothing_and_never_across(factor: float) -> None:
    grid = grid_of()
    grid.log_odds.flat = np.linspace(-4600, 4600, grid.log_odds.size)
    before = grid.log_odds.astype(np.int64)
    grid.fade(factor)
    after = grid.log_odds.astype(np.int64)
    assert np.all(np.abs(after) <= np.abs(before) * factor + 1e-9)
    assert np.all(after * before >= 0)
    assert np.all(np.abs(after - before * factor) <= 1.0)


def test_a_faded_cell_is_not_unknown_again() -> None:
    grid = grid_of()
    grid.update(sounding_of((Pose(), Ranger("sonar", Pose(), 0.3, 0.0, 4.0), 1.0)))
    known = ~grid.unknown()
    grid.fade(0.0)
    assert np.array_equal(~grid.unknown(), known)
    assert known.any()


def test_a_copy_goes_its_own_way() -> None:
    grid = grid_of()
    twin = grid.copy()
    twin.update(sounding_of((Pose(), Ranger("sonar", Pose(), 0.3, 0.0, 4.0), 1.0)))
    assert not grid.log_odds.any()
    assert grid.unknown().all()
    assert twin.log_odds.any()


def test_the_cells_move_with_the_window() -> None:
    grid = grid_of()
    grid.log_odds[3, 4] = 700
    grid.move(GridGeometry(0.2, -1.8, -2.4, 20, 20), (-2, 1))
    assert grid.log_odds[5, 3] == 700
    assert np.count_nonzero(grid.log_odds) == 1


@pytest.mark.parametrize(("nats", "expected"), [(-4.6, 0.00995), (-2.0, 0.1192), (0.0, 0.5), (2.0, 0.8808)])
def test_milli_nats_as_probabilities(nats: float, expected: float) -> None:
    assert probability(np.array([round(nats * 1000)], np.int16))[0] == approx(expected, abs=1e-4)
