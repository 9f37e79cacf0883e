from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echogrid.emulation.worlds import WORLDS
from echogrid.mapping.cone import cast
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.sounding import Sounding
from echogrid.runtime.contenders import contenders
from echogrid.runtime.map_suite import (
    RESOLUTION_M,
    Contender,
    Trial,
    Verdict,
    arena,
    judge,
    judged_cells,
    spoken_of,
    standings,
    trial,
)
from echogrid.runtime.ring_recording import RingPing

from .theories import ignorant, truth_of

CHEAT = Contender("cheat", truth_of, saturates=False)
IGNORANT = Contender("ignorant", ignorant)


@cache
def lap() -> Trial:
    whole = trial("foyer", 1)
    return replace(whole, pings=whole.pings[:600])


def timeless(verdict: Verdict) -> Verdict:
    return replace(verdict, microseconds_per_ping=0.0)


def test_the_arena_holds_every_cone_of_the_lap() -> None:
    whole = trial("foyer", 1)
    for ping in whole.pings[::50]:
        (top, right), sounding = whole.geometry.shape, ping.sounding
        rows, cols = cast(whole.geometry, replace(sounding, echo=None)).patch
        assert rows.start > 0 < cols.start
        assert rows.stop < top
        assert cols.stop < right


def test_cells_are_judged_that_an_echo_spoke_of_and_that_are_walls_or_in_reach() -> None:
    at, venue = lap(), WORLDS["foyer"]()
    walls, possible = judged_cells(venue, arena(venue))
    assert np.array_equal(at.walls, walls)
    assert not (at.judged & ~possible).any()
    assert 1000 < at.judged.sum() < possible.sum()
    assert 0.02 < at.walls[at.judged].mean() < 0.5


def test_silence_makes_no_cell_judged() -> None:
    soundings = [ping.sounding for ping in lap().pings]
    silent = [replace(sounding, echo=None) for sounding in soundings]
    geometry = lap().geometry
    assert not spoken_of(geometry, silent).any()
    loud = [sounding for sounding in soundings if sounding.echo is not None]
    assert np.array_equal(spoken_of(geometry, soundings), spoken_of(geometry, loud))


def test_what_an_echo_speaks_of_are_its_regions_i_and_ii() -> None:
    sounding = next(ping.sounding for ping in lap().pings if ping.sounding.echo is not None)
    cone = cast(lap().geometry, sounding)
    spoken = spoken_of(lap().geometry, [sounding])
    assert spoken.sum() == len(cone.rows)
    assert spoken[cone.rows, cone.cols].all()


def test_the_truth_is_beyond_reproach() -> None:
    verdict = judge(CHEAT, lap())
    assert (verdict.f1, verdict.best_f1, verdict.overlap, verdict.free_recall) == (1.0, 1.0, 1.0, 1.0)
    assert (verdict.auc, verdict.skill, verdict.average_precision) == pytest.approx((1.0, 1.0, 1.0))
    assert (verdict.score, verdict.bits, verdict.phantoms, verdict.missed) == (0.0, 0.0, 0.0, 0.0)


def test_who_knows_nothing_calls_nothing_occupied_or_free() -> None:
    verdict = judge(IGNORANT, lap())
    assert (verdict.f1, verdict.free_recall, verdict.missed) == (0.0, 0.0, 1.0)
    assert (verdict.auc, verdict.bits, verdict.score_per_cell) == pytest.approx((0.5, 1.0, 0.5))


def test_a_theory_that_saturates_is_kept_from_certainty_before_its_loss_is_reckoned() -> None:
    clipped = judge(replace(CHEAT, saturates=True), lap())
    assert clipped.nats == pytest.approx(-np.log(0.99))
    assert clipped.score == 0.0


def test_the_threshold_is_the_theory_s() -> None:
    low = judge(replace(IGNORANT, threshold=0.4), lap())
    assert low.recall == 1.0
    assert low.precision < 1.0


def test_the_lower_threshold_does_not_call_unknown_cells_occupied() -> None:
    one = replace(lap(), pings=lap().pings[:1])
    assert judge(replace(contenders()[0], threshold=0.1), one).recall < 0.05


def test_a_theory_is_judged_by_the_cells_that_an_echo_spoke_of_whatever_it_hears_itself() -> None:
    def deaf(ping: RingPing) -> Sounding:
        return replace(ping.sounding, echo=None)

    assert timeless(judge(replace(IGNORANT, hear=deaf), lap())) == timeless(judge(IGNORANT, lap()))


def test_cells_a_ping_are_those_of_which_it_speaks_to_an_empty_map() -> None:
    at = lap()
    one = replace(at, pings=at.pings[:1])
    assert judge(IGNORANT, one).cells_per_ping == at.geometry.rows * at.geometry.cols
    echo = next(ping for ping in at.pings if ping.sounding.echo is not None)
    ignoring = next(each for each in contenders() if each.name.endswith("consistent, no echo: ignore"))
    spoken = judge(ignoring, replace(at, pings=(echo,))).cells_per_ping
    assert 0.5 * len(cast(at.geometry, echo.sounding).rows) < spoken
    assert spoken <= len(cast(at.geometry, echo.sounding).rows)


def test_a_theory_is_told_the_world_in_which_it_is_judged() -> None:
    seen = []

    def learned_elsewhere(world: str, geometry: GridGeometry) -> object:
        seen.append(world)
        return ignorant(world, geometry)

    judge(Contender("learned", learned_elsewhere), replace(lap(), pings=lap().pings[:1]))
    assert set(seen) == {"foyer"}


def test_all_processes_together_find_what_one_finds() -> None:
    both = [each for each in contenders() if "consistent, no echo: i" in each.name]
    one, two = (standings(["foyer"], (1, 2), both, processes) for processes in (1, 2))
    assert list(one) == [each.name for each in both]
    for name, rows in one.items():
        assert [[timeless(v) for v in row] for row in rows] == [
            [timeless(v) for v in row] for row in two[name]
        ]
        assert [len(row) for row in rows] == [2]
        assert rows[0][0].auc != rows[0][1].auc


def test_the_grid_has_the_cells_that_the_goals_are_for() -> None:
    assert arena(WORLDS["museum"]()).resolution == RESOLUTION_M == 0.1
