from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.latency import Latency

MS = 1_000_000


def told(stamp_ms: int, outcome: Outcome = Outcome.ECHO, listened: bool = False) -> RangeReading:
    return RangeReading(stamp_ms * MS, 0, "front", outcome, 1.0, listened=listened)


@given(st.lists(st.tuples(st.integers(0, 400), st.integers(0, 300)), max_size=40))
def test_it_is_the_longest_age_of_the_last_two_seconds(ticks: list[tuple[int, int]]) -> None:
    latency, now_ms, taken = Latency(), 1000, []
    for step, age in ticks:
        now_ms += step
        taken.append((now_ms, age))
        latency.take([told(now_ms - age)], now_ms * MS)
        assert latency.worst_ns == max(a for t, a in taken if now_ms - t <= 2000) * MS
        assert latency.newest_ns == max(t - a for t, a in taken) * MS


def test_faults_and_turns_that_only_listened_tell_nothing() -> None:
    latency = Latency()
    latency.take([told(10, Outcome.INVALID), told(20, listened=True)], 500 * MS)
    assert (latency.newest_ns, latency.worst_ns) == (0, 0)
    latency.take([told(400, Outcome.NO_ECHO)], 500 * MS)
    assert (latency.newest_ns, latency.worst_ns) == (400 * MS, 100 * MS)


def test_a_stamp_from_the_future_is_now() -> None:
    latency = Latency()
    latency.take([told(600)], 500 * MS)
    assert (latency.newest_ns, latency.worst_ns) == (500 * MS, 0)
