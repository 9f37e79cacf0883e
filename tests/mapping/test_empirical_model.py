from math import log, radians

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.cone import Cone, cast
from echogrid.mapping.empirical_model import FEWEST, USUAL, Bins, Empirical, Tally
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.sounding import Sounding

from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-2.0, -2.0, 4.0, 2.0, 0.1)
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.0, 4.0)
BINS = Bins((-1.0, -0.2, 0.2), (0.0, 0.1, 0.3), (0.0, 1.0, 3.0))

pings = st.tuples(poses(3.0), rangers(0.05), st.none() | st.floats(0.0, 4.0))


def cone_of(echo: float | None, bins: Bins = BINS) -> Cone:
    return cast(GEOMETRY, bins.believed(Sounding(Pose(0.0, 0.05), SONAR, echo, 0.1)))


def all_known(cone: Cone) -> np.ndarray:
    return np.ones(len(cone.rows), np.bool_)


def bin_by_hand(borders: tuple[float, ...], value: float) -> int | None:
    for index in range(len(borders) - 1):
        if borders[index] <= value < borders[index + 1]:
            return index
    return None


@settings(deadline=None)
@given(st.lists(pings, min_size=1, max_size=4), st.integers(0, 2**32 - 1))
def test_the_tally_counts_each_known_cell_in_its_bin(many, seed: int) -> None:
    chance = np.random.default_rng(seed)
    tally, due = Tally(BINS), {True: np.zeros((2, 2, 2, 2)), False: np.zeros((2, 2, 2))}
    for ping in many:
        cone = cast(GEOMETRY, BINS.believed(Sounding(*ping, 0.1)))
        truth, known = chance.random(len(cone.rows)) < 0.3, chance.random(len(cone.rows)) < 0.8
        tally.add(cone, truth, known)
        for r, alpha, occupied, sure in zip(cone.distance, cone.bearing, truth, known, strict=True):
            s = ping[2]
            place = [bin_by_hand(BINS.bearing, alpha), bin_by_hand(BINS.distance, r if s is None else s)]
            if s is not None:
                place.insert(0, bin_by_hand(BINS.offset, r - s))
            if sure and None not in place:
                due[s is not None][(int(occupied), *place)] += 1
    assert np.array_equal(tally.echo, due[True])
    assert np.array_equal(tally.silence, due[False])


@given(st.integers(0, 500), st.integers(0, 500))
@example(20, FEWEST - 20)
@example(20, FEWEST - 21)
def test_a_bin_is_worth_its_odds_against_those_of_all_cells_and_nothing_if_it_saw_few(
    occupied: int, empty: int
) -> None:
    tally = Tally(BINS)
    tally.echo[:, 0, 0, 0] = (900, 100)
    tally.echo[:, 1, 1, 1] = (empty, occupied)
    tally.silence[:, 1, 0] = (50, 7)
    base = log(100 + occupied + 7 + 1) - log(900 + empty + 50 + 1)
    due = log(occupied + 1) - log(empty + 1) - base if occupied + empty >= FEWEST else 0.0
    model = tally.model()
    assert model.of_echo[1, 1, 1] == approx(due, abs=1e-9)
    assert model.of_silence[1, 0] == approx(log(8 / 51) - base, abs=1e-9)
    assert np.count_nonzero(model.of_echo) <= 2


def test_without_samples_it_says_nothing() -> None:
    model = Tally().model()
    grid = BayesGrid(GEOMETRY, 4.6, model, NoEcho.WEAK)
    assert grid.update(Sounding(Pose(), SONAR, 1.0, 0.1)) is None
    assert grid.unknown().all()


@settings(deadline=None)
@given(pings, st.sampled_from(NoEcho))
def test_a_cell_gets_what_stands_in_its_bin_and_outside_the_bins_nothing(ping, no_echo: NoEcho) -> None:
    chance = np.random.default_rng(5)
    model = Empirical(BINS, chance.normal(size=(2, 2, 2)), chance.normal(size=(2, 2)))
    cone = cast(GEOMETRY, model.believed(Sounding(*ping, 0.1)))
    found = model.echo(cone) if cone.echo else model.silence(cone)
    s = ping[2]
    for r, alpha, value in zip(cone.distance, cone.bearing, found, strict=True):
        place = [bin_by_hand(BINS.bearing, alpha), bin_by_hand(BINS.distance, r if s is None else s)]
        if s is not None:
            place.insert(0, bin_by_hand(BINS.offset, r - s))
        table = model.of_silence if s is None else model.of_echo
        assert value == (0.0 if None in place else table[tuple(place)])
    grid = BayesGrid(GEOMETRY, 4.6, model, no_echo)
    grid.update(Sounding(*ping, 0.1))
    assert np.all((grid.occupancy() > 0.0) & (grid.occupancy() < 1.0))


def test_it_learns_a_wall_and_draws_it_where_bayes_was_told_nothing_else() -> None:
    """A wall at 2 m: the cells of its column are occupied."""
    tally = Tally()
    for step in range(40):
        seat = Pose(0.0, -1.0 + 0.05 * step)
        cone = cast(GEOMETRY, USUAL.believed(Sounding(seat, SONAR, 2.05, 0.1)))
        tally.add(cone, cone.cols == 40, all_known(cone))
    model = tally.model()
    grid = BayesGrid(GEOMETRY, 4.6, model, NoEcho.IGNORE)
    grid.update(Sounding(Pose(0.0, 0.05), SONAR, 2.05, 0.1))
    row = grid.occupancy()[20]
    assert row[40] > 0.9
    assert np.all(row[25:36] < 0.5)


def test_a_tempered_model_says_so_much_of_it() -> None:
    chance = np.random.default_rng(1)
    model = Empirical(BINS, chance.normal(size=(2, 2, 2)), chance.normal(size=(2, 2)))
    for cone in (cone_of(1.0), cone_of(None)):
        assert model.tempered(0.2).echo(cone) == approx(0.2 * model.echo(cone))


@pytest.mark.parametrize(
    "borders",
    [
        ((0.0,), (0.0, 0.1), (0.0, 1.0)),
        ((0.0, 0.1), (0.1, 0.1), (0.0, 1.0)),
        ((-1.0, 0.0), (0.0, 0.1), (0.0, 1.0)),
    ],
)
def test_bins_without_room_are_refused(borders: tuple[tuple[float, ...], ...]) -> None:
    with pytest.raises(ValueError, match="bins"):
        Bins(*borders)


def test_tables_of_another_shape_or_without_numbers_are_refused() -> None:
    with pytest.raises(ValueError, match="shapes"):
        Empirical(BINS, np.zeros((2, 2, 3)), np.zeros((2, 2)))
    with pytest.raises(ValueError, match="finite"):
        Empirical(BINS, np.full((2, 2, 2), np.nan), np.zeros((2, 2)))
