from math import tau

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.steering.sectors import Opening, apart, openings, ring_sum, to_sectors

circles = st.lists(st.booleans(), min_size=8, max_size=72).map(np.array)


@given(circles)
def test_openings_hold_each_free_sector_once_and_no_blocked_one(blocked: np.ndarray) -> None:
    n = len(blocked)
    held = [k % n for opening in openings(blocked) for k in range(opening.right, opening.left + 1)]
    free = np.flatnonzero(~blocked).tolist()
    assert sorted(held) == (free if blocked.any() else [])


@given(circles)
def test_an_opening_ends_at_what_is_blocked(blocked: np.ndarray) -> None:
    n = len(blocked)
    for opening in openings(blocked):
        assert 0 <= opening.right < n
        assert opening.right <= opening.left
        assert blocked[opening.right - 1]
        assert blocked[(opening.left + 1) % n]


def test_an_opening_across_the_seam_is_one() -> None:
    blocked = np.ones(72, np.bool_)
    blocked[[70, 71, 0, 1, 2]] = False
    assert openings(blocked) == [Opening(70, 74)]
    assert Opening(70, 74).width == 4


@given(st.floats(0.0, 72.0), st.floats(0.0, 72.0))
def test_two_sectors_are_apart_the_short_way_round(one: float, other: float) -> None:
    assert apart(one, other, 72) == approx(min((one - other) % 72, (other - one) % 72), abs=1e-9)
    assert 0.0 <= apart(one, other, 72) <= 36.0


@given(st.lists(st.integers(-9, 9), min_size=8, max_size=30), st.sampled_from([1, 3, 5, 7]))
def test_a_ring_sum_goes_across_the_seam(values: list[int], width: int) -> None:
    half, n = width // 2, len(values)
    expected = [sum(values[(k + i) % n] * (i + 9) for i in range(-half, half + 1)) for k in range(n)]
    weights = np.arange(half, -half - 1, -1) + 9.0
    assert ring_sum(np.array(values, np.float64), weights).tolist() == expected


@given(st.floats(-1e6, 1e6))
def test_an_angle_is_in_one_sector_of_the_circle(angle: float) -> None:
    assert 0.0 <= to_sectors(angle, 72) <= 72.0
    assert apart(to_sectors(angle, 72), angle / tau * 72, 72) == approx(0.0, abs=1e-6)
