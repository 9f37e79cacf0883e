from collections.abc import Sequence
from itertools import combinations, product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.drivers.pace import Span
from echogrid.runtime.firing_patterns import AUDIBLE_NS, MOST_STEPS, PATTERNS, Cycle, Seat, delays

MS = 1_000_000
PERIOD = 100 * MS
STEP = 1_200_000


CYCLE = Cycle(PERIOD, STEP)
COMMAND, ANSWER = (0, 300_000), (36 * MS, 38 * MS)


def seats(count: int, groups: int, busy: tuple[Span, ...] = (COMMAND,), buses: int = 1) -> tuple[Seat, ...]:
    return tuple(Seat(PERIOD * (n % groups) // groups, f"bus {n % buses}", busy) for n in range(count))


def found(ring: tuple[Seat, ...], cycle: Cycle = CYCLE) -> tuple[tuple[int, ...], ...]:
    result = delays(ring, cycle)
    assert len(result) == len(ring)
    return result


def all_find_it_idle(ring: tuple[Seat, ...], cycle: Cycle, late_ns: Sequence[int]) -> bool:
    """Whether no command has to wait for what was begun before it on its bus; each cycle begins later."""
    transfers = sorted(
        (turn_ns + start_ns, end_ns - start_ns, start_ns == 0, seat.bus)
        for seat, own in zip(ring, found(ring, cycle), strict=True)
        for number, late in enumerate(late_ns)
        for turn_ns in [seat.offset_ns + number * cycle.period_ns + own[number % PATTERNS] + late]
        for start_ns, end_ns in seat.busy
    )
    idle_ns = {seat.bus: 0 for seat in ring}
    for start_ns, lasts_ns, is_command, bus in transfers:
        if is_command and start_ns < idle_ns[bus]:
            return False
        idle_ns[bus] = max(idle_ns[bus], start_ns) + lasts_ns
    return True


def differences(ring: tuple[Seat, ...], listener: int, source: int, shift: int) -> list[int]:
    """t_j - t_i in each cycle of the rotation, of the source's turn so many cycles later."""
    own, other = (found(ring)[index] for index in (listener, source))
    lag = ring[source].offset_ns + shift * PERIOD - ring[listener].offset_ns
    return [lag + other[(m + shift) % PATTERNS] - own[m] for m in range(PATTERNS)]


rings = st.builds(
    seats, st.integers(2, 14), st.integers(1, 5), st.sampled_from([(COMMAND,), (COMMAND, ANSWER)]), st.just(2)
)


@settings(max_examples=20, deadline=None)
@given(rings)
def test_the_difference_of_any_two_changes_from_cycle_to_cycle(ring: tuple[Seat, ...]) -> None:
    for i in range(len(ring)):
        for j in range(len(ring)):
            lags = differences(ring, i, j, 0)
            assert i == j or all(abs(a - b) >= STEP for a, b in combinations(lags, 2))


@settings(max_examples=20, deadline=None)
@given(rings)
def test_it_changes_across_the_end_of_a_cycle_too_where_that_is_heard(ring: tuple[Seat, ...]) -> None:
    for shift in (-1, 1):
        for i in range(len(ring)):
            for j in set(range(len(ring))) - {i}:
                lags = [lag for lag in differences(ring, i, j, shift) if abs(lag) <= AUDIBLE_NS]
                assert all(abs(a - b) >= STEP for a, b in combinations(lags, 2))


@settings(max_examples=20, deadline=None)
@given(rings)
def test_every_command_finds_its_bus_idle(ring: tuple[Seat, ...]) -> None:
    assert all_find_it_idle(ring, CYCLE, [0] * 7)


@pytest.mark.parametrize("late_ns", tuple(product((0, 5 * MS), repeat=5)))
def test_so_it_does_when_each_cycle_begins_later_by_chance(late_ns: tuple[int, ...]) -> None:
    ring = seats(8, 3, (COMMAND, (36 * MS, 39 * MS)))
    assert all_find_it_idle(ring, Cycle(PERIOD, STEP, 5 * MS), late_ns)


def test_one_that_holds_its_bus_is_kept_from_those_of_the_next_cycle_too() -> None:
    """In the middle of a cycle, when nobody of the next is heard."""
    long = Seat(PERIOD // 2, "bus", ((0, 60 * MS),))
    ring = (Seat(0, "bus", (COMMAND,)), long)
    assert all_find_it_idle(ring, CYCLE, [0] * 7)


def test_each_has_three_delays_in_whole_steps() -> None:
    for delays_ns in found(seats(16, 4)):
        assert len(delays_ns) == PATTERNS
        assert all(delay_ns % STEP == 0 for delay_ns in delays_ns)


def test_sixteen_are_told_apart_within_a_fifth_of_their_cycle() -> None:
    assert max(map(max, found(seats(16, 4)))) <= 20 * MS


def test_the_delays_of_one_are_close_together_however_late_it_fires() -> None:
    for delays_ns in found(seats(4, 1, ((0, 20 * MS),))):
        assert max(delays_ns) - min(delays_ns) <= MOST_STEPS * STEP


def test_where_the_bus_has_no_room_for_more_these_have_none() -> None:
    assert len(delays(seats(6, 1, ((0, 20 * MS),)), CYCLE)) == 4
    assert len(delays(seats(2 * MOST_STEPS + 2, 1, ()), CYCLE)) <= 2 * MOST_STEPS + 1


def test_nobody_needs_none() -> None:
    assert delays((), CYCLE) == ()
