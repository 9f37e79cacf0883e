from hypothesis import given
from hypothesis import strategies as st

from echogrid.mapping.gap import GapWatch

MS = 1_000_000


def after(intervals: list[int]) -> GapWatch:
    watch = GapWatch()
    for interval in intervals:
        watch.is_gap(interval)
    return watch


@given(st.integers(1, 1000), st.integers(3, 40))
def test_more_than_three_usual_intervals_are_a_gap(usual: int, many: int) -> None:
    assert after([usual * MS] * many).is_gap(3 * usual * MS + 1)
    assert not after([usual * MS] * many).is_gap(3 * usual * MS)


@given(st.lists(st.integers(1, 10**10), max_size=3))
def test_the_first_intervals_are_no_gaps(intervals: list[int]) -> None:
    watch = GapWatch()
    assert not any(watch.is_gap(interval) for interval in intervals)


def test_a_gap_does_not_make_the_next_one_usual() -> None:
    watch = after([10 * MS] * 10)
    assert [watch.is_gap(500 * MS), watch.is_gap(10 * MS), watch.is_gap(500 * MS)] == [True, False, True]


def test_encoders_which_slowed_down_for_good_are_steady_again() -> None:
    watch = after([10 * MS] * 15)
    assert [watch.is_gap(50 * MS) for _ in range(9)] == [True] * 8 + [False]
