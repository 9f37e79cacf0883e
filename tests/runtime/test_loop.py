from collections.abc import Sequence
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.runtime.loop import FixedRateLoop

from .fakes import MS, SECOND, HandClock

PERIOD = 20 * MS
DELAYS = st.lists(st.integers(0, 10 * PERIOD) | st.integers(0, PERIOD // 2), max_size=30)


def run(loop: FixedRateLoop, clock: HandClock, works: Sequence[int], until_ns: int) -> list[tuple[int, int]]:
    """When each tick started and ended, if each took as long as `works` says, and then no time."""
    spans = []
    left = list(works)
    for start_ns in loop.ticks(until_ns):
        clock.time_ns += left.pop(0) if left else 0
        spans.append((start_ns, clock.time_ns))
    return spans


def loop_on(clock: HandClock) -> FixedRateLoop:
    return FixedRateLoop(clock, SECOND / PERIOD)


def test_on_a_perfect_clock_every_tick_is_in_time_on_its_deadline() -> None:
    clock = HandClock(5 * MS)
    loop = loop_on(clock)
    spans = run(loop, clock, (), 5 * MS + 10 * PERIOD)
    assert [start for start, _ in spans] == [5 * MS + k * PERIOD for k in range(1, 10)]
    assert (loop.in_time, loop.late, loop.skipped, loop.worst_ns) == (9, 0, 0, 0)
    assert loop.punctuality == 1.0


@pytest.mark.parametrize(
    ("late_ns", "work_ns", "in_time"),
    [
        (PERIOD // 2, 0, True),
        (PERIOD // 2 + 1, 0, False),
        (0, PERIOD, True),
        (0, PERIOD + 1, False),
        (PERIOD // 2, PERIOD // 2, True),
        (PERIOD // 2, PERIOD // 2 + 1, False),
    ],
)
def test_a_tick_is_in_time_if_it_starts_within_half_a_period_and_ends_before_the_next(
    late_ns: int, work_ns: int, in_time: bool
) -> None:
    clock = HandClock(late_ns=[late_ns])
    loop = loop_on(clock)
    run(loop, clock, [work_ns], 2 * PERIOD)
    assert (loop.in_time, loop.late, loop.skipped) == (int(in_time), int(not in_time), 0)


def test_lateness_does_not_move_later_deadlines() -> None:
    clock = HandClock(late_ns=[3 * MS, 7 * MS, 1 * MS])
    starts = [start for start, _ in run(loop_on(clock), clock, (), 5 * PERIOD)]
    assert starts == [PERIOD + 3 * MS, 2 * PERIOD + 7 * MS, 3 * PERIOD + 1 * MS, 4 * PERIOD]


def test_after_a_long_tick_the_missed_ones_are_skipped_and_counted() -> None:
    clock = HandClock()
    loop = loop_on(clock)
    starts = [start for start, _ in run(loop, clock, [5 * PERIOD + 3 * MS], 9 * PERIOD)]
    assert starts == [PERIOD, 6 * PERIOD + 3 * MS, 7 * PERIOD, 8 * PERIOD]
    assert (loop.in_time, loop.late, loop.skipped) == (3, 1, 4)


def test_after_a_sleep_that_was_much_too_long_the_next_tick_waits_for_its_own_deadline() -> None:
    clock = HandClock(late_ns=[5 * PERIOD + 15 * MS])
    loop = loop_on(clock)
    starts = [start for start, _ in run(loop, clock, [1 * MS], 9 * PERIOD)]
    assert starts == [6 * PERIOD + 15 * MS, 7 * PERIOD, 8 * PERIOD]
    assert (loop.in_time, loop.late, loop.skipped) == (2, 1, 5)
    assert loop.worst_ns == 5 * PERIOD + 15 * MS


@given(late=DELAYS, works=DELAYS)
def test_whatever_stalls_no_two_ticks_start_in_one_period(late: list[int], works: list[int]) -> None:
    clock = HandClock(late_ns=late)
    starts = [start for start, _ in run(loop_on(clock), clock, works, 400 * PERIOD)]
    slots = [start // PERIOD for start in starts]
    assert all(before < after for before, after in pairwise(slots))


@given(late=DELAYS, works=DELAYS)
def test_every_deadline_is_in_time_late_or_skipped(late: list[int], works: list[int]) -> None:
    clock = HandClock(late_ns=late)
    loop = loop_on(clock)
    spans = run(loop, clock, works, 1000 * PERIOD)
    assert loop.in_time + loop.late == len(spans)
    assert loop.in_time + loop.late + loop.skipped == 999


def test_a_loop_that_has_not_ticked_is_punctual() -> None:
    assert FixedRateLoop(HandClock(), 50.0).punctuality == 1.0


def test_a_time_shorter_than_a_period_has_no_tick() -> None:
    clock = HandClock()
    assert run(loop_on(clock), clock, (), PERIOD) == []
