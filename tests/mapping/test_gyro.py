from math import cos, sin

from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.gyro import Gyro

MS = 1_000_000
SECOND = 1000 * MS


def steady(rate: float, seconds: float = 4.0) -> Gyro:
    gyro = Gyro()
    for step in range(round(seconds * 100) + 1):
        gyro.add(step * 10 * MS, rate)
    return gyro


@given(st.floats(-4.0, 4.0), st.integers(0, 2 * SECOND), st.integers(1, 2 * SECOND))
def test_a_steady_rate_turns_in_proportion_to_the_time(rate: float, start_ns: int, length_ns: int) -> None:
    turned = steady(rate).turned(start_ns, start_ns + length_ns)
    assert turned == approx(rate * length_ns * 1e-9, abs=1e-9)


@given(st.lists(st.floats(-4.0, 4.0), min_size=4, max_size=30), st.data())
def test_turns_one_after_the_other_add_up(rates: list[float], data: st.DataObject) -> None:
    gyro = Gyro()
    for step, rate in enumerate(rates):
        gyro.add(step * 10 * MS, rate)
    stamps = st.integers(0, (len(rates) - 1) * 10 * MS)
    start, middle, end = sorted(
        data.draw(st.tuples(stamps, stamps, stamps).filter(lambda s: len(set(s)) == 3))
    )
    parts = gyro.turned(start, middle), gyro.turned(middle, end)
    assert None not in parts
    assert gyro.turned(start, end) == approx(sum(part or 0.0 for part in parts), abs=1e-9)


def test_a_swinging_rate_is_integrated() -> None:
    gyro = Gyro()
    for step in range(401):
        gyro.add(step * 10 * MS, cos(0.01 * step))
    assert gyro.turned(0, 3 * SECOND) == approx(sin(3.0), abs=1e-5)


def test_what_the_rates_do_not_cover_is_not_known() -> None:
    gyro = steady(1.0, 1.0)
    assert gyro.turned(500 * MS, SECOND + 1) is None
    assert gyro.turned(-1, 500 * MS) is None
    assert Gyro().turned(0, 1) is None


def test_over_a_gap_of_the_rates_nothing_is_known() -> None:
    gyro = steady(1.0, 1.0)
    for step in range(30):
        gyro.add(SECOND + 300 * MS + step * 10 * MS, 1.0)
    assert gyro.turned(900 * MS, SECOND + 400 * MS) is None
    assert gyro.turned(SECOND + 300 * MS, SECOND + 400 * MS) == approx(0.1)


def test_a_rate_that_is_not_the_newest_is_refused() -> None:
    gyro = steady(1.0, 1.0)
    assert not gyro.add(SECOND, 5.0)
    assert gyro.add(SECOND + 1, 5.0)


@given(st.floats(-0.1, 0.1))
def test_standing_shows_the_bias(bias: float) -> None:
    gyro = steady(bias)
    assert not gyro.settled
    for step in range(60):
        gyro.stood(step * 10 * MS, (step + 1) * 10 * MS)
    assert gyro.settled
    assert gyro.bias == approx(bias, abs=1e-12)
    assert gyro.turned(0, 3 * SECOND) == approx(0.0, abs=1e-9)


def test_the_bias_follows_a_drift_but_not_at_once() -> None:
    gyro = Gyro()
    for step in range(4001):
        gyro.add(step * 10 * MS, 0.01 if step < 1000 else 0.03)
        if step:
            gyro.stood((step - 1) * 10 * MS, step * 10 * MS)
        if step == 1100:
            assert gyro.bias < 0.013
    assert 0.02 < gyro.bias < 0.03


def test_it_reaches_back_ten_seconds_but_not_for_ever() -> None:
    gyro = steady(0.5, 60.0)
    assert gyro.turned(50 * SECOND, 60 * SECOND) == approx(5.0)
    assert gyro.turned(0, SECOND) is None
