from math import cos, pi, radians, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping.cone import cast
from echogrid.mapping.evidence import DIRECTIONS, MILLI, SILENCE_REACH, CellEvidence, shared
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sounding import Sounding

from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-3.0, -3.0, 3.0, 3.0, 0.1)
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.1, 5.0)

soundings = st.builds(Sounding, poses(3.0), rangers(), st.none() | st.floats(0.0, 4.0), st.just(0.12))


def evidence(*pings: Sounding) -> CellEvidence:
    kept = CellEvidence(GEOMETRY)
    for ping in pings:
        kept.add(ping)
    return kept


@settings(deadline=None)
@given(st.lists(soundings, max_size=6))
def test_every_ping_speaks_of_the_cells_of_its_cone_alone(pings: list[Sounding]) -> None:
    touched = np.zeros(GEOMETRY.shape, np.bool_)
    for ping in pings:
        cone = cast(GEOMETRY, ping)
        touched[cone.rows, cone.cols] = True
    for each in evidence(*pings).statistics:
        assert not each[..., ~touched].any()


@settings(deadline=None)
@given(st.lists(soundings, max_size=6))
def test_no_number_is_negative_and_none_but_sums_passes_one(pings: list[Sounding]) -> None:
    s = evidence(*pings).statistics
    assert all(np.all(each >= 0) for each in s)
    assert np.all(s.best <= MILLI)
    assert np.all(s.share <= s.share.dtype.type(len(pings) * MILLI))
    assert np.all(s.hit_from < 1 << DIRECTIONS)


@settings(deadline=None)
@given(soundings)
def test_one_echo_gives_one_echo_s_worth_of_claims(ping: Sounding) -> None:
    claims = evidence(ping).statistics.share.sum() / MILLI
    assert claims <= 1.0 + 0.0005 * GEOMETRY.rows * GEOMETRY.cols
    if ping.echo is None:
        assert claims == 0.0


def test_a_wall_s_echo_is_claimed_by_the_cell_that_others_have_hit_too() -> None:
    towards = Sounding(Pose(0.0, 0.0, 0.0), SONAR, 2.0, 0.12)
    across = Sounding(Pose(2.0, -2.0, pi / 2.0), SONAR, 2.0, 0.12)
    s = evidence(across, towards).statistics
    row, col = GEOMETRY.cell(2.0, 0.0)
    aside, _ = GEOMETRY.cell(2.0, 0.35)
    share = s.share.sum(axis=0)
    assert share[row, col] > 2 * share[aside, col]


def test_a_claim_is_kept_by_the_direction_from_which_the_echo_came_there_or_back() -> None:
    for angle in np.arange(16) * pi / 8.0:
        ping = Sounding(Pose(-cos(angle), -sin(angle), angle), SONAR, 1.0, 0.12)
        row, col = GEOMETRY.cell(0.0, 0.0)
        shares = evidence(ping).statistics.share[:, row, col]
        assert np.flatnonzero(shares).tolist() == [round(angle / pi * 8.0) % 8]


def test_two_hundred_identical_pings_say_what_one_says() -> None:
    ping = Sounding(Pose(0.0, 0.0, 0.3), SONAR, 1.5, 0.12)
    once, often = evidence(ping), evidence(*[ping] * 200)
    assert all(np.array_equal(a, b) for a, b in zip(once.statistics, often.statistics, strict=True))


def test_two_rangers_at_one_place_are_two() -> None:
    other = Ranger("other", Pose(), radians(15.0), 0.1, 5.0)
    ping = Sounding(Pose(), SONAR, 1.5, 0.12)
    both = evidence(ping, Sounding(Pose(), other, 1.5, 0.12)).statistics
    assert both.hit.sum() == 2 * evidence(ping).statistics.hit.sum()


def test_directions_are_told_apart() -> None:
    pings = [
        Sounding(Pose(0.0, 0.0, 0.0), SONAR, 2.0, 0.12),
        Sounding(Pose(2.0, 2.0, -pi / 2), SONAR, 2.0, 0.12),
    ]
    s = evidence(*pings).statistics
    row, col = GEOMETRY.cell(2.0, 0.0)
    assert int(s.hit_from[row, col]).bit_count() == 2
    row, col = GEOMETRY.cell(1.0, 0.0)
    assert int(s.missed_from[row, col]).bit_count() == 1


def test_it_is_kept_from_how_near_and_how_central_a_cell_was_hit() -> None:
    pings = [
        Sounding(Pose(-2.0, 0.05, 0.0), SONAR, 3.0, 0.12),
        Sounding(Pose(0.0, 0.05, 0.2), SONAR, 1.0, 0.12),
    ]
    s = evidence(*pings).statistics
    cell = GEOMETRY.cell(1.05, 0.05)
    assert s.nearest[cell] == pytest.approx(1050, abs=1)
    assert s.best[cell] == 1000


def test_silence_is_told_of_what_is_near() -> None:
    s = evidence(Sounding(Pose(-2.9, 0.0, 0.0), SONAR, None, 0.12)).statistics
    assert s.silent[GEOMETRY.cell(-1.0, 0.0)] > 0
    assert s.silent[GEOMETRY.cell(-2.9 + SILENCE_REACH + 0.1, 0.0)] == 0
    assert not s.hit.any()
    assert not s.miss.any()


def test_a_twin_goes_its_own_way() -> None:
    one = evidence(Sounding(Pose(), SONAR, 1.0, 0.12))
    twin, before = one.copy(), one.statistics.hit.copy()
    twin.add(Sounding(Pose(0.5, 0.0), SONAR, 1.0, 0.12))
    assert np.array_equal(one.statistics.hit, before)
    assert not np.array_equal(twin.statistics.hit, before)


def test_a_ping_from_afar_touches_nothing() -> None:
    assert CellEvidence(GEOMETRY).add(Sounding(Pose(50.0, 0.0), SONAR, 1.0, 0.12)) is None


def test_an_echo_is_shared_out_by_weight_and_likelihood() -> None:
    shares = shared(np.array([1.0 * 0.5, 0.5 * 0.1]))
    assert shares == pytest.approx([0.8771930, 0.0877193], abs=1e-6)
    assert 1.0 - shares.sum() == pytest.approx(0.0350877, abs=1e-6)
