from hypothesis import given
from hypothesis import strategies as st

from echogrid.runtime.outputs.pace import Pace

from .views import at

MS = 1_000_000


@given(st.floats(1.0, 200.0), st.lists(st.integers(1, 300), min_size=1, max_size=60))
def test_no_two_views_go_out_in_one_period_and_none_is_late_by_more_than_a_tick(
    rate_hz: float, steps: list[int]
) -> None:
    pace, now_ns, sent = Pace(rate_hz), 0, []
    for step in steps:
        now_ns += step * MS
        if pace.due(at(now_ns)):
            sent.append(now_ns)
        else:
            assert now_ns - sent[-1] < pace.period_ns
    slots = [(stamp_ns - sent[0]) // pace.period_ns for stamp_ns in sent]
    assert len(set(slots)) == len(slots)


def test_a_stop_that_begins_does_not_wait_but_one_that_lasts_does() -> None:
    pace = Pace(10.0)
    story = [(0, False), (20, False), (40, True), (60, True), (80, False), (100, False), (120, True)]
    assert [pace.due(at(t * MS, stop)) for t, stop in story] == [True, False, True, False, False, True, True]
