import pytest

from echogrid.runtime import crosstalk_check
from echogrid.runtime.crosstalk_check import PATTERNS, Shares, shares

METRES = 3.0


@pytest.fixture(scope="module")
def found() -> dict[str, Shares]:
    wanted = "all at once", "EERUF"
    return {name: shares(PATTERNS[name], 1, METRES) for name in wanted}


def test_of_sixteen_that_fire_at_once_more_than_a_tenth_of_all_readings_is_false(
    found: dict[str, Shares],
) -> None:
    assert found["all at once"].false > 0.1


def test_eeruf_lets_less_than_a_hundredth_through_and_keeps_nine_of_ten_true_ones(
    found: dict[str, Shares],
) -> None:
    assert found["EERUF"].cycle_ms <= 100.0
    assert found["EERUF"].let_through < 0.01
    assert found["EERUF"].kept >= 0.9


def test_the_book_s_comparison_alone_keeps_fewer(found: dict[str, Shares]) -> None:
    assert found["EERUF"].kept_at_once < found["EERUF"].kept


def test_the_same_seed_gives_the_same_figures(found: dict[str, Shares]) -> None:
    assert shares(PATTERNS["EERUF"], 1, METRES) == found["EERUF"]


def test_the_table_has_a_row_for_each_pattern() -> None:
    head, rule, *rows = crosstalk_check.table(1, 0.1)
    assert head.startswith("| 16 sonars, 0.1 m of the office | cycle |")
    assert {line.count("|") for line in (head, rule, *rows)} == {8}
    assert len(rows) == len(PATTERNS)
