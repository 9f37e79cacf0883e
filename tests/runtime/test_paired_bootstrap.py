import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from echogrid.runtime.paired_bootstrap import paired_bootstrap

DRAWS = 500
figures = arrays(np.float64, (4, 3), elements=st.floats(-1.0, 1.0, width=16))


@given(figures, figures)
def test_the_difference_of_the_other_way_round_is_the_opposite(one: np.ndarray, other: np.ndarray) -> None:
    there, back = paired_bootstrap(one, other, 1, DRAWS), paired_bootstrap(other, one, 1, DRAWS)
    assert there.mean == pytest.approx(-back.mean)
    assert (there.low, there.high) == pytest.approx((-back.high, -back.low))
    assert there.p == back.p


@given(figures, figures)
def test_p_is_a_probability_and_the_interval_is_in_order(one: np.ndarray, other: np.ndarray) -> None:
    d = paired_bootstrap(one, other, 1, DRAWS)
    assert 0.0 < d.p <= 1.0
    assert d.low <= d.high
    assert d.mean == pytest.approx((one - other).mean())


@given(figures)
def test_no_theory_differs_from_itself(one: np.ndarray) -> None:
    d = paired_bootstrap(one, one, 1, DRAWS)
    assert (d.mean, d.low, d.high, d.p) == (0.0, 0.0, 0.0, 1.0)


@given(figures, st.floats(0.01, 1.0))
def test_what_is_better_everywhere_is_better_for_sure(one: np.ndarray, by: float) -> None:
    d = paired_bootstrap(one + by, one, 1, DRAWS)
    assert d.p == pytest.approx(2 / (DRAWS + 1))
    assert d.low == pytest.approx(by)


def test_two_theories_that_take_turns_are_not_told_apart() -> None:
    one = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 1.0]])
    assert paired_bootstrap(one, 1.0 - one).p > 0.5


def test_five_laps_through_the_one_world_in_which_it_is_better_are_no_proof() -> None:
    one = np.zeros((4, 5))
    one[0] = 1.0
    assert paired_bootstrap(one, np.zeros((4, 5))).p > 0.3


def test_seeds_are_drawn_too() -> None:
    one = np.array([[1.0, -0.9, 1.0, -0.9, 1.0]])
    assert paired_bootstrap(one, np.zeros_like(one)).p > 0.1


def test_the_same_seed_draws_the_same() -> None:
    one = np.random.default_rng(0).normal(size=(4, 3))
    other = np.zeros((4, 3))
    assert paired_bootstrap(one, other) == paired_bootstrap(one, other)
    assert paired_bootstrap(one, other, seed=2) != paired_bootstrap(one, other)
