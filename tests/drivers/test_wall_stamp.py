"""Kernel time stamps brought to the monotonic clock, whatever the wall clock does meanwhile."""

import time

from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers.transports.wall_stamp import TOLERANCE_NS, WallStamps, wall_offset_ns

SECOND_NS = 1_000_000_000
OFFSET_NS = 1_700_000_000 * SECOND_NS
NOW_NS = 50 * SECOND_NS


class Clocks:
    """How far the wall clock is ahead; it can be set."""

    def __init__(self) -> None:
        self.offset_ns = OFFSET_NS

    def __call__(self) -> int:
        return self.offset_ns


def stamps_after_a_step(step_ns: int, seen_ns: int) -> WallStamps:
    """With a frame at `seen_ns`, and the wall clock set by a step after it."""
    clocks = Clocks()
    stamps = WallStamps(clocks)
    stamps.monotonic_ns(OFFSET_NS + seen_ns, seen_ns)
    clocks.offset_ns += step_ns
    stamps.check()
    return stamps


def test_the_clocks_are_read_as_they_stand() -> None:
    assert abs(time.time_ns() - time.monotonic_ns() - wall_offset_ns()) < SECOND_NS


@given(st.integers(0, NOW_NS))
def test_a_stamp_is_brought_to_the_monotonic_clock(age_ns: int) -> None:
    assert WallStamps(Clocks()).monotonic_ns(OFFSET_NS + NOW_NS - age_ns, NOW_NS) == NOW_NS - age_ns


@given(st.integers(-TOLERANCE_NS, TOLERANCE_NS))
def test_a_little_unrest_of_the_clocks_changes_nothing(unrest_ns: int) -> None:
    stamps = stamps_after_a_step(unrest_ns, NOW_NS - SECOND_NS)
    assert stamps.monotonic_ns(OFFSET_NS + NOW_NS, NOW_NS) == NOW_NS


@given(st.integers(-3600, 3600).filter(bool))
def test_a_frame_stamped_after_the_wall_clock_was_set_is_right(step_s: int) -> None:
    stamps = stamps_after_a_step(step_s * SECOND_NS, NOW_NS - SECOND_NS // 2)
    stamp_ns = stamps.monotonic_ns(OFFSET_NS + step_s * SECOND_NS + NOW_NS, NOW_NS)
    assert stamp_ns == NOW_NS


@given(st.integers(-3600, 3600).filter(bool))
def test_a_frame_stamped_before_the_wall_clock_was_set_is_right(step_s: int) -> None:
    stamps = stamps_after_a_step(step_s * SECOND_NS, NOW_NS - SECOND_NS // 2)
    stamp_ns = stamps.monotonic_ns(OFFSET_NS + NOW_NS - SECOND_NS // 4, NOW_NS)
    assert stamp_ns == NOW_NS - SECOND_NS // 4


def test_a_stamp_that_fits_no_clock_is_now() -> None:
    assert WallStamps(Clocks()).monotonic_ns(0, NOW_NS) == NOW_NS


@given(st.lists(st.integers(-TOLERANCE_NS, NOW_NS), min_size=2))
def test_stamps_never_lie_in_the_future(ages_ns: list[int]) -> None:
    stamps = WallStamps(Clocks())
    for age_ns in ages_ns:
        assert stamps.monotonic_ns(OFFSET_NS + NOW_NS - age_ns, NOW_NS) <= NOW_NS
