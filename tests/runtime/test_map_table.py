from collections.abc import Iterable
from dataclasses import fields, replace

import numpy as np
import pytest

from echogrid.runtime import map_table
from echogrid.runtime.contenders import contenders
from echogrid.runtime.map_suite import Contender, Standings, Verdict
from echogrid.runtime.map_table import BOOK, COMPARED, MORE, QUALITY, Column, difference_table, standing_table
from echogrid.runtime.sensitivity import MeanSway

from .theories import counting, ignorant

TRIALS = "2 worlds x 2 seeds"


def verdict(**figures: float) -> Verdict:
    return replace(Verdict(*(0.0 for _ in fields(Verdict))), **figures)


def laps(figure: str, *worlds: Iterable[float]) -> list[list[Verdict]]:
    return [[verdict(**{figure: value}) for value in world] for world in worlds]


def cells(row: str) -> list[str]:
    return [cell.strip() for cell in row.strip("|").split("|")]


def test_every_figure_of_a_verdict_has_its_column() -> None:
    columns = [column.figure for column in (*QUALITY, *MORE, *BOOK)]
    assert sorted(columns) == sorted(field.name for field in fields(Verdict))


def test_a_row_tells_the_mean_and_the_worst_world_s_mean() -> None:
    found = {"theory": laps("auc", (0.9, 1.0), (0.5, 0.7))}
    _, _, row = standing_table(found, (Column("AUC", "auc"),), TRIALS)
    assert cells(row) == ["theory", "0.775 / 0.600"]


def test_the_worst_of_a_figure_that_should_be_low_is_the_highest() -> None:
    found = {"theory": laps("phantoms", (0.1, 0.1), (0.02, 0.02))}
    column = next(column for column in QUALITY if column.figure == "phantoms")
    _, _, row = standing_table(found, (column,), TRIALS)
    assert cells(row) == ["theory", "6.0% / 10.0%"]


def test_theories_of_others_are_compared_with_the_best_of_the_book_in_each_figure() -> None:
    found: Standings = {
        "old": laps("auc", *[(0.7, 0.7)] * 3),
        "older": laps("auc", *[(0.5, 0.5)] * 3),
        "new": laps("auc", *[(0.9, 0.9)] * 3),
    }
    book = [Contender(name, ignorant, of_the_book=True) for name in ("old", "older")]
    head, _, row = difference_table(found, [*book, Contender("new", ignorant)])
    assert len(cells(head)) == 2 + len(COMPARED)
    assert cells(row)[:3] == ["new", "the best of the book", "+0.200 (+0.200 to +0.200), p = 0.0002"]
    assert cells(row)[3] == "+0.000 (+0.000 to +0.000), p = 1"


def test_theories_of_others_are_compared_with_each_other_too() -> None:
    found: Standings = {
        "new": laps("auc", *[(0.8, 0.8)] * 3),
        "newer": laps("auc", *[(0.9, 0.9)] * 3),
    }
    _, _, row = difference_table(found, [Contender(name, ignorant) for name in found])
    assert cells(row)[:3] == ["newer", "new", "+0.100 (+0.100 to +0.100), p = 0.0002"]


def test_of_two_worlds_no_more_is_told_than_the_difference() -> None:
    found: Standings = {"new": laps("auc", *[(0.8,)] * 2), "newer": laps("auc", *[(0.9,)] * 2)}
    _, _, row = difference_table(found, [Contender(name, ignorant) for name in found])
    assert cells(row)[2] == "+0.100"


def test_a_theory_alone_is_compared_with_nothing() -> None:
    found = {"new": laps("auc", (0.9, 0.9))}
    assert len(list(difference_table(found, [Contender("new", ignorant)]))) == 2


def test_the_stationary_robot_has_a_row_for_each_theory() -> None:
    theories = [Contender("stubborn", ignorant), Contender("gullible", counting)]
    head, rule, *rows = map_table.stationary_table(theories, "museum")
    assert {row.count("|") for row in (head, rule, *rows)} == {head.count("|")}
    assert [cells(row)[-1] for row in rows] == ["as much as 1", "more than 3"]
    assert cells(rows[1])[1] == "0.500 / 0.750 / 0.995"


def test_the_sensitivity_tells_both_changes_and_the_largest() -> None:
    *_, row = map_table.sensitivity_table([MeanSway("theory", "beta", (-0.03, 0.01), 0.1)])
    assert cells(row) == ["theory", "beta", "-0.030", "+0.010", "0.030", "0.100"]


def test_all_tables_are_whole() -> None:
    chosen = [each for each in contenders() if each.name.endswith("consistent, no echo: ignore")]
    calm = replace(chosen[0], name="calm", of_the_book=False, saturates=False, numbers=None)
    lines = list(map_table.tables(["foyer"], (1,), [*chosen, calm]))
    text = "\n".join(lines)
    tables = [block.splitlines() for block in text.split("\n\n") if block.startswith("|")]
    assert len(tables) == 6
    for rows in tables:
        assert len({row.count("|") for row in rows}) == 1
        assert len(rows) > 2
    assert "these do not: calm." in text
    assert "nan" not in text


@pytest.mark.parametrize(("high", "worst", "best"), [(True, 0.1, 0.3), (False, 0.3, 0.1)])
def test_a_column_knows_which_side_is_good(high: bool, worst: float, best: float) -> None:
    column = Column("figure", "auc", high_is_good=high)
    assert column.worst(np.array([0.1, 0.2, 0.3])) == worst
    assert column.best([0.1, 0.2, 0.3]) == best
