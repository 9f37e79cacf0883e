from hypothesis import given
from hypothesis import strategies as st
from pytest import mark

from echogrid.drivers.uptime import COUNTER, Uptime

MS = 1_000_000


def wrapped(milliseconds: int) -> int:
    return (milliseconds + COUNTER // 2) % COUNTER - COUNTER // 2


@given(
    begun=st.integers(0, 2 * COUNTER),
    pause_ms=st.integers(0, 10_000_000),
    drift=st.floats(-0.04, 0.04),
    late_ms=st.integers(-15, 15),
)
def test_a_counter_that_goes_on_is_no_restart(begun: int, pause_ms: int, drift: float, late_ms: int) -> None:
    uptime = Uptime()
    assert not uptime.restarted(0, wrapped(begun))
    counted = round(pause_ms * (1 + drift))
    assert not uptime.restarted((pause_ms + late_ms) * MS, wrapped(begun + counted))


@given(
    before=st.integers(1_000, COUNTER // 2 - 1),
    pause_ms=st.integers(300, 19_000),
    up=st.floats(0.0, 1.0),
)
def test_a_counter_that_has_begun_since_is_a_restart(before: int, pause_ms: int, up: float) -> None:
    uptime = Uptime()
    uptime.restarted(0, before)
    assert uptime.restarted(pause_ms * MS, round(up * pause_ms)) or before <= 20 + 0.05 * pause_ms


@mark.parametrize("late_ms", [200, 5_000])
def test_a_late_message_is_no_restart(late_ms: int) -> None:
    uptime = Uptime()
    uptime.restarted(0, 3_600_000)
    assert not uptime.restarted((20 + late_ms) * MS, 3_600_020)
    assert not uptime.restarted((40 + late_ms) * MS, 3_600_040)
