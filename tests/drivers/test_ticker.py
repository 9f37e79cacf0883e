from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.ticker import Ticker


def test_it_ticks_from_its_start_on_until_it_is_stopped() -> None:
    ticker = Ticker(10)
    assert not ticker.due(5)
    ticker.start(5)
    ticker.start(7)
    assert [now_ns for now_ns in range(5, 40) if ticker.due(now_ns)] == [5, 15, 25, 35]
    ticker.stop()
    assert ticker.deadline_ns == NEVER_NS and not ticker.due(1000)


@given(st.lists(st.integers(0, 1000)))
def test_a_stall_is_skipped_and_the_beat_kept(pauses: list[int]) -> None:
    ticker, now_ns = Ticker(10), 3
    ticker.start(now_ns)
    for pause in pauses:
        now_ns += pause
        expected = now_ns >= ticker.deadline_ns
        assert ticker.due(now_ns) == expected
        assert not ticker.due(now_ns)
        assert now_ns < ticker.deadline_ns <= now_ns + 10
        assert ticker.deadline_ns % 10 == 3
