from math import hypot

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.emulation.walker import Walker

WALKER = Walker(((0.0, 0.0), (3.0, 0.0), (3.0, 4.0)), start=1.0)
times = st.floats(0.0, 500.0)


@given(times, st.floats(0.0, 0.5))
def test_somebody_walks_no_faster_than_they_do(time_s, step):
    before, after = WALKER.at(time_s), WALKER.at(time_s + step)
    assert hypot(after.x - before.x, after.y - before.y) <= WALKER.speed * step + 1e-9


@given(times)
def test_along_a_line_they_walk_at_their_speed(time_s):
    before, after = WALKER.at(time_s), WALKER.at(time_s + 1e-3)
    turns = (WALKER.start + WALKER.speed * time_s) % WALKER.lap_length
    if min(abs(turns - corner) for corner in (0.0, 3.0, 7.0, 12.0)) > 0.01:
        assert hypot(after.x - before.x, after.y - before.y) == pytest.approx(0.8e-3, rel=1e-3)


@given(times, st.integers(1, 20))
def test_every_round_is_the_same(time_s, rounds):
    again = WALKER.at(time_s + rounds * WALKER.lap_length / WALKER.speed)
    assert again[:2] == pytest.approx(WALKER.at(time_s)[:2], abs=1e-6)


def test_they_begin_on_their_way_and_pass_the_way_points_in_order():
    assert WALKER.at(0.0)[:2] == pytest.approx((1.0, 0.0))
    assert WALKER.at(2.0 / 0.8)[:2] == pytest.approx((3.0, 0.0))
    assert WALKER.at(6.0 / 0.8)[:2] == pytest.approx((3.0, 4.0))
    assert WALKER.at(8.5 / 0.8)[:2] == pytest.approx((1.5, 2.0))


def test_they_wear_clothes_and_have_a_girth():
    assert WALKER.at(0.0)[2:] == (0.22, 12.0)
