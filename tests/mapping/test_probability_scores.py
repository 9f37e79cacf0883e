import json
from math import inf, isnan, log
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pytest import approx

from echogrid.mapping.probability_scores import (
    NATS_IN_A_BIT,
    area_under_curve,
    average_precision,
    base_log_loss,
    book_score,
    brier,
    calibration_error,
    correlation,
    log_loss,
    map_score,
    skill,
)

WORKED = Path(__file__).parents[3] / "shared/vectors/worked.json"
TRUTH = np.array([[0, 0, 0, 1]] * 3, bool).ravel()
MAP = np.array([[0.1, 0.2, 0.5, 0.7], [0.1, 0.3, 0.6, 0.9], [0.2, 0.1, 0.4, 0.45]]).ravel()
VECTOR = {
    "11.score eq11.16": 3.45,
    "11.log-loss bits/cell": 0.540993,
    "11.Brier": 0.114375,
    "11.AUC": 0.9259259,
    "11.Pearson": 0.7037146,
}
"""Of the toy map."""

sizes = st.shared(st.integers(2, 60), key="cells")
probabilities = sizes.flatmap(lambda size: arrays(np.float64, size, elements=st.floats(0.01, 0.99)))
ties = sizes.flatmap(lambda size: arrays(np.float64, size, elements=st.sampled_from([0.2, 0.5, 0.9])))
truths = sizes.flatmap(lambda size: arrays(np.bool_, size)).filter(lambda truth: 0 < truth.sum() < len(truth))
maps = probabilities | ties


def scores() -> dict[str, float]:
    return {
        "11.score eq11.16": book_score(MAP, TRUTH),
        "11.log-loss bits/cell": log_loss(MAP, TRUTH) / NATS_IN_A_BIT,
        "11.Brier": brier(MAP, TRUTH),
        "11.AUC": area_under_curve(MAP, TRUTH),
        "11.Pearson": correlation(MAP, TRUTH),
    }


def test_the_toy_map_has_the_scores_that_were_worked_out() -> None:
    assert scores() == approx(VECTOR, abs=1e-6)


@pytest.mark.skipif(not WORKED.exists(), reason="no shared/vectors/worked.json beside the project")
def test_the_toy_map_has_the_scores_of_the_vectors() -> None:
    worked = json.loads(WORKED.read_text())
    assert scores() == approx({name: worked[name] for name in VECTOR}, abs=1e-6)


@given(maps, truths)
def test_scores_are_within_their_bounds(p: np.ndarray, truth: np.ndarray) -> None:
    for score in (brier, area_under_curve, average_precision, calibration_error):
        assert -1e-12 <= score(p, truth) <= 1.0 + 1e-12
    assert -1.0 - 1e-9 <= correlation(p, truth) <= 1.0 + 1e-9
    assert 0.0 <= book_score(p, truth) <= len(p)
    assert skill(p, truth) < 1.0


@given(maps, truths)
def test_auc_counts_the_pairs_that_are_in_order(p: np.ndarray, truth: np.ndarray) -> None:
    above = p[truth][:, np.newaxis] - p[~truth][np.newaxis, :]
    assert area_under_curve(p, truth) == approx(np.mean(np.where(above == 0, 0.5, above > 0)))


@given(maps, truths)
def test_auc_and_ap_see_nothing_but_the_order(p: np.ndarray, truth: np.ndarray) -> None:
    _, ranks = np.unique(p, return_inverse=True)
    monotone = ranks / len(p)
    assert area_under_curve(monotone, truth) == approx(area_under_curve(p, truth))
    assert average_precision(monotone, truth) == approx(average_precision(p, truth))


@given(maps, truths)
def test_a_map_turned_inside_out_has_the_rest_of_the_auc_to_1(p: np.ndarray, truth: np.ndarray) -> None:
    assert area_under_curve(-p, truth) == approx(1.0 - area_under_curve(p, truth))


def test_rounding_makes_no_correlation() -> None:
    p, truth = np.array([0.01, 0.01]), np.array([False, True])
    assert correlation(p, truth) == correlation(1.0 - p, ~truth) == 0.0


@given(maps, truths)
def test_occupied_and_free_may_change_places(p: np.ndarray, truth: np.ndarray) -> None:
    p = np.rint(p * 2.0**20) / 2.0**20  # so that 1 - p is exact: what differs goes on to differ
    for score in (book_score, log_loss, brier, correlation, map_score, area_under_curve):
        assert score(1.0 - p, ~truth) == approx(score(p, truth), abs=1e-9)


@given(maps, truths, st.randoms(use_true_random=False))
def test_the_order_of_the_cells_does_not_matter(p: np.ndarray, truth: np.ndarray, random) -> None:
    order = list(range(len(p)))
    random.shuffle(order)
    for score in (book_score, log_loss, area_under_curve, average_precision, calibration_error, correlation):
        assert score(p[order], truth[order]) == approx(score(p, truth), abs=1e-9)


@given(maps, truths)
def test_nothing_has_a_lower_loss_than_the_truth_or_a_lower_constant_one_than_the_base(
    p: np.ndarray, truth: np.ndarray
) -> None:
    assert log_loss(truth.astype(np.float64), truth) == 0.0 <= log_loss(p, truth)
    constant = np.full(len(truth), p[0])
    assert log_loss(constant, truth) >= base_log_loss(truth) - 1e-12
    base = np.full(len(truth), truth.mean())
    assert (log_loss(base, truth), skill(base, truth)) == approx((base_log_loss(truth), 0.0), abs=1e-9)


@given(truths)
def test_the_truth_is_perfect(truth: np.ndarray) -> None:
    p = truth.astype(np.float64)
    assert (book_score(p, truth), brier(p, truth), calibration_error(p, truth)) == (0.0, 0.0, 0.0)
    perfect = skill(p, truth), area_under_curve(p, truth), average_precision(p, truth), correlation(p, truth)
    assert perfect == approx((1.0, 1.0, 1.0, 1.0))
    assert map_score(p, truth) == len(truth)


@given(truths)
def test_a_map_that_knows_nothing_scores_nothing(truth: np.ndarray) -> None:
    p = np.full(len(truth), 0.5)
    assert area_under_curve(p, truth) == 0.5
    assert average_precision(p, truth) == approx(truth.mean())
    assert correlation(p, truth) == 0.0
    assert map_score(p, truth) == approx(0.0, abs=1e-9)
    assert log_loss(p, truth) == approx(log(2.0))


@given(maps, truths)
def test_the_map_score_is_the_sum_over_the_cells(p: np.ndarray, truth: np.ndarray) -> None:
    summed = sum(1.0 + np.log2(q * t + (1.0 - q) * (1.0 - t)) for q, t in zip(p, truth, strict=True))
    assert map_score(p, truth) == approx(summed, abs=1e-9)


@given(maps, truths)
def test_the_calibration_error_is_that_of_ten_bins(p: np.ndarray, truth: np.ndarray) -> None:
    error = 0.0
    for tenth in range(10):
        inside = np.minimum(np.floor(p * 10), 9) == tenth
        if inside.any():
            error += abs(p[inside].mean() - truth[inside].mean()) * inside.mean()
    assert calibration_error(p, truth) == approx(error, abs=1e-9)


def test_eight_of_ten_that_are_said_to_be_so_to_eight_tenths_are_calibrated() -> None:
    truth = np.array([True] * 8 + [False] * 2)
    assert calibration_error(np.full(10, 0.8), truth) == approx(0.0)
    assert calibration_error(np.full(10, 0.99), truth) == approx(0.19)


def test_certainty_has_a_bin() -> None:
    assert calibration_error(np.array([0.0, 1.0]), np.array([False, True])) == 0.0


def test_a_cell_that_was_thought_impossible_costs_everything() -> None:
    assert log_loss(np.array([0.0, 0.5]), np.array([True, False])) == inf


@pytest.mark.parametrize("alike", [True, False])
def test_what_needs_both_kinds_of_cells_is_nan_without(alike: bool) -> None:
    truth, p = np.full(4, alike), np.array([0.1, 0.4, 0.6, 0.9])
    assert isnan(area_under_curve(p, truth))
    assert isnan(skill(p, truth))
    assert correlation(p, truth) == 0.0
    assert isnan(average_precision(p, np.zeros(4, bool)))
