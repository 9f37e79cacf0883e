from itertools import combinations

from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.runtime.firing_patterns import AUDIBLE_NS, MOST_STEPS, PATTERNS, Seat, delays

MS = 1_000_000
PERIOD = 100 * MS
STEP = 1_200_000


def seats(count: int, groups: int, held_ns: int = 300_000) -> tuple[Seat, ...]:
    return tuple(Seat(PERIOD * (n % groups) // groups, "bus", held_ns) for n in range(count))


def found(ring: tuple[Seat, ...]) -> tuple[tuple[int, ...], ...]:
    result = delays(ring, PERIOD, STEP)
    assert result is not None
    return result


def differences(ring: tuple[Seat, ...], listener: int, source: int, shift: int) -> list[int]:
    """t_j - t_i in each cycle of the rotation, of the source's turn so many cycles later."""
    own, other = (found(ring)[index] for index in (listener, source))
    lag = ring[source].offset_ns + shift * PERIOD - ring[listener].offset_ns
    return [lag + other[(m + shift) % PATTERNS] - own[m] for m in range(PATTERNS)]


rings = st.builds(seats, st.integers(2, 18), st.integers(1, 5))


@settings(max_examples=30, deadline=None)
@given(rings)
def test_the_difference_of_any_two_changes_from_cycle_to_cycle(ring: tuple[Seat, ...]) -> None:
    for i in range(len(ring)):
        for j in range(len(ring)):
            lags = differences(ring, i, j, 0)
            assert i == j or all(abs(a - b) >= STEP for a, b in combinations(lags, 2))


@settings(max_examples=30, deadline=None)
@given(rings)
def test_it_changes_across_the_end_of_a_cycle_too_where_that_is_heard(ring: tuple[Seat, ...]) -> None:
    for shift in (-1, 1):
        for i in range(len(ring)):
            for j in set(range(len(ring))) - {i}:
                lag = ring[j].offset_ns + shift * PERIOD - ring[i].offset_ns
                if abs(lag) <= AUDIBLE_NS:
                    lags = differences(ring, i, j, shift)
                    assert all(abs(a - b) >= STEP for a, b in combinations(lags, 2))


@settings(max_examples=30, deadline=None)
@given(rings)
def test_two_on_one_bus_never_fire_while_it_is_held(ring: tuple[Seat, ...]) -> None:
    chosen = found(ring)
    for i, j in combinations(range(len(ring)), 2):
        for own, other in zip(chosen[i], chosen[j], strict=True):
            assert abs(ring[i].offset_ns + own - ring[j].offset_ns - other) >= 300_000


def test_each_has_three_delays_in_whole_steps() -> None:
    for delays_ns in found(seats(16, 4)):
        assert len(delays_ns) == PATTERNS
        assert all(delay_ns % STEP == 0 for delay_ns in delays_ns)


def test_sixteen_are_told_apart_within_a_fifth_of_their_cycle() -> None:
    assert max(map(max, found(seats(16, 4)))) <= 20 * MS


def test_where_they_would_wait_for_each_other_there_are_none() -> None:
    assert delays(seats(4, 1, 20 * MS), PERIOD, STEP) is None
    assert delays(seats(2 * MOST_STEPS + 2, 1), PERIOD, STEP) is None


def test_nobody_needs_none() -> None:
    assert delays((), PERIOD, STEP) == ()
