from pathlib import Path
from runpy import run_path

import numpy as np
from pytest import fixture

from echogrid.mapping.calibrated import Judge
from echogrid.mapping.network import Network
from echogrid.mapping.network_training import Lesson
from echogrid.runtime.learning import Look, looks, taught, write

LESSON = Lesson(hidden=3, epochs=2)


@fixture(scope="module")
def seen() -> list[Look]:
    return [*looks(2), *looks(5)]


@fixture(scope="module")
def judge(seen: list[Look]) -> Judge:
    return taught(seen, LESSON)


def test_what_is_learned_from_is_known_and_both_free_and_occupied(seen: list[Look]) -> None:
    for each in seen:
        assert len(each.told) == np.count_nonzero(each.known)
        assert each.chosen.max() < len(each.told)
        assert 0.005 < each.occupied.mean() < 0.6


def test_even_a_short_lesson_tells_walls_from_free_floor(seen: list[Look], judge: Judge) -> None:
    other = looks(8)[-1]
    odds = judge.own.log_odds(other.told[other.chosen].astype(np.float64))
    assert np.median(odds[other.occupied]) > np.median(odds[~other.occupied]) + 2.0


def test_the_same_worlds_teach_the_same(seen: list[Look], judge: Judge) -> None:
    again = taught(seen, LESSON)
    assert np.array_equal(again.again.hidden, judge.again.hidden)


def test_what_is_written_down_is_what_was_learned(judge: Judge, tmp_path: Path) -> None:
    write(judge, tmp_path / "weights.py")
    numbers = run_path(str(tmp_path / "weights.py"))
    for name, network in zip(("OWN", "CONTEXT", "AGAIN"), judge, strict=True):
        read = Network.of(numbers[name])
        assert all(
            np.array_equal(a, b)
            for a, b in zip(read.numbers().values(), network.numbers().values(), strict=True)
        )
