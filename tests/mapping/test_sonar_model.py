"""The sonar model. Numbers of the book are in feet and degrees: R = 10, half angle 15, Max_occ 0.98."""

from itertools import permutations
from math import ceil, exp, log, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.cone import belief, cast
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import (
    Form,
    NoEcho,
    consistent,
    evidence,
    log_odds,
    no_echo_log_odds,
    posterior,
    printed,
)
from echogrid.mapping.sounding import Sounding

from .strategies import poses, rangers

REACH = 10.0
HALF_ANGLE = radians(15.0)
TOLERANCE = 0.5
THREE_READINGS = (0.5226666667, 0.62, 0.175)
SILENCES = [(0.9, -2.2512918, 0.0952381), (0.5, -0.6418539, 0.3448276), (0.3, -0.3053816, 0.4242424)]
SILENCES += [(0.1, -0.0540672, 0.4864865)]

beliefs = st.floats(0.0, 1.0)


def book_belief(distance: float, degrees: float) -> np.ndarray:
    return belief(np.array([distance]), np.array([radians(degrees)]), REACH, HALF_ANGLE)


def by_book(model, distance: float, degrees: float, echo: float) -> float:
    return model(book_belief(distance, degrees), np.array([distance >= echo - TOLERANCE]))[0]


def odds(probability: float) -> float:
    return log_odds(np.array([probability]))[0]


def sigmoid(value: float) -> float:
    return 1.0 / (1.0 + exp(-value))


@given(beliefs)
def test_the_consistent_form_raises_where_the_echo_came_from_and_lowers_before(strength: float) -> None:
    occupied, empty = consistent(np.array([strength, strength]), np.array([True, False]))
    assert 0.0 <= empty <= 0.5 <= occupied <= 0.99


@given(beliefs, st.booleans())
def test_the_consistent_form_is_the_printed_one_drawn_half_way_to_one_half(
    strength: float, occupied: bool
) -> None:
    """Half of the book's Dempster-Shafer mass that is left over goes to either side."""
    b, region = np.array([strength]), np.array([occupied])
    mass = printed(b, region) if occupied else 1.0 - printed(b, region)
    towards = 1.0 if occupied else 0.0
    assert consistent(b, region) == approx(mass * towards + (1.0 - mass) / 2.0)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_log_odds_of_any_number_are_finite_and_bounded(probability: float) -> None:
    assert abs(odds(probability)) <= log(999.0) + 1e-9


@given(st.floats(1e-3, 1.0 - 1e-3))
def test_log_odds_and_the_logistic_function_undo_each_other(probability: float) -> None:
    assert sigmoid(odds(probability)) == approx(probability, abs=1e-12)


@given(st.floats(0.0, 0.999))
def test_silence_never_speaks_for_an_obstacle(detection: float) -> None:
    assert no_echo_log_odds(np.array([detection]))[0] <= 0.0


@settings(deadline=None)
@given(
    poses(),
    rangers(),
    st.none() | st.floats(0, 6),
    st.sampled_from(Form),
    st.sampled_from(NoEcho),
)
def test_the_evidence_of_any_ping_is_a_finite_number_for_each_cell(
    seat: Pose, ranger: Ranger, echo: float | None, form: Form, no_echo: NoEcho
) -> None:
    cone = cast(GridGeometry.covering(-6, -6, 6, 6, 0.2), Sounding(seat, ranger, echo, 0.1))
    found = evidence(cone, form, no_echo)
    assert found.shape == cone.rows.shape
    assert np.all(np.isfinite(found))


def silent_cone():
    ranger = Ranger("sonar", Pose(), HALF_ANGLE, 0.0, REACH)
    return cast(GridGeometry.covering(0, -5, 11, 5, 0.1), Sounding(Pose(0.0, 0.05), ranger, None, TOLERANCE))


def test_silence_may_be_ignored() -> None:
    assert not evidence(silent_cone(), Form.CONSISTENT, NoEcho.IGNORE).any()


def test_weak_silence_says_nothing_8_degrees_off_the_axis_or_beyond_0_6_of_the_reach() -> None:
    cone = silent_cone()
    found = evidence(cone, Form.CONSISTENT, NoEcho.WEAK)
    beyond = (cone.bearing > radians(8.0)) | (cone.distance > 6.0)
    assert not found[beyond].any()
    assert found.min() == approx(log(0.55 / 0.95), abs=1e-2)


def test_clear_silence_empties_the_whole_cone() -> None:
    found = evidence(silent_cone(), Form.CONSISTENT, NoEcho.CLEAR)
    assert found == approx(log_odds(consistent(silent_cone().belief, np.zeros(len(found), bool))))
    assert np.all(found < 0.0)


def test_figure_11_4_a_cell_before_the_echo() -> None:
    occupied = by_book(printed, 3.5, 0.0, 6.0)
    assert (occupied, 1.0 - occupied) == approx((0.175, 0.825), abs=1e-6)
    assert (occupied, 1.0 - occupied) == approx((0.17, 0.83), abs=0.006)


def test_figure_11_5_a_cell_at_the_echo() -> None:
    occupied = by_book(printed, 6.0, 5.0, 6.0)
    assert (occupied, 1.0 - occupied) == approx((0.5226666667, 0.4773333333), abs=1e-6)
    assert (occupied, 1.0 - occupied) == approx((0.52, 0.48), abs=0.006)


def test_figure_11_15_a_far_cell_on_the_axis() -> None:
    occupied = by_book(printed, 9.0, 0.0, 9.0)
    assert (occupied, 1.0 - occupied) == approx((0.539, 0.461), abs=1e-6)


def test_0_62_is_not_the_cell_of_figure_11_5() -> None:
    assert by_book(printed, 6.0, 2.0204081632653046, 6.0) == approx(0.62, abs=1e-6)
    assert book_belief(4.013605442176869, 5.0)[0] * 0.98 == approx(0.62, abs=1e-6)
    assert by_book(printed, 4.013605442176869, 5.0, 6.0) < 0.5


@pytest.mark.parametrize(
    ("occupied", "empty", "prior", "expected"),
    [
        (0.62, 0.38, 0.5, 0.62),
        (0.62, 0.38, 0.75, 0.8303571),
        (0.5226666667, 0.4773333333, 0.75, 0.7666232),
    ],
)
def test_equation_11_4_weighs_the_reading_with_the_prior(
    occupied: float, empty: float, prior: float, expected: float
) -> None:
    assert posterior(occupied, empty, prior) == approx(expected, abs=1e-6)


@pytest.mark.parametrize("order", list(permutations(THREE_READINGS)))
def test_equation_11_6_gives_the_same_in_any_order(order: tuple[float, ...]) -> None:
    chained = 0.5
    for occupied in order:
        chained = posterior(occupied, 1.0 - occupied, chained)
    assert chained == approx(0.2748168, abs=1e-6)
    assert chained == approx(sigmoid(sum(odds(p) for p in THREE_READINGS)), abs=1e-12)


def test_the_orders_of_equation_11_6_differ_by_rounding_alone() -> None:
    results = []
    for order in permutations(THREE_READINGS):
        chained = 0.5
        for occupied in order:
            chained = posterior(occupied, 1.0 - occupied, chained)
        results.append(chained)
    assert max(results) - min(results) <= 1e-15


def test_the_log_odds_of_the_three_readings() -> None:
    found = [odds(p) for p in THREE_READINGS]
    assert found == approx([0.0907289, 0.4895482, -1.5505974], abs=1e-6)
    assert sigmoid(sum(found)) == approx(0.2748168, abs=1e-6)


@pytest.mark.parametrize(
    ("distance", "degrees", "echo", "expected"),
    [(3.5, 0.0, 6.0, 0.0875), (6.0, 5.0, 6.0, 0.7613333), (8.0, 12.0, 9.5, 0.4), (9.0, 5.0, 9.0, 0.6878333)],
)
def test_the_consistent_form_at_the_book_s_cells(
    distance: float, degrees: float, echo: float, expected: float
) -> None:
    assert by_book(consistent, distance, degrees, echo) == approx(expected, abs=1e-6)


def test_the_printed_form_takes_far_empty_space_for_an_obstacle_and_an_echo_for_empty_space() -> None:
    assert by_book(printed, 8.0, 12.0, 9.5) == approx(0.80, abs=1e-6)
    assert by_book(printed, 9.0, 5.0, 9.0) == approx(0.3756667, abs=1e-6)


def wrong_part(nearest: float, farthest: float, region_1: bool) -> float:
    """The part of a region's area whose probability is on the wrong side of 1/2.

    By the midpoint rule over the distance; on each arc the angle at which the printed model changes sides is
    found by halving.
    """
    steps = 2000
    distance = nearest + (np.arange(steps) + 0.5) / steps * (farthest - nearest)
    low, high = np.zeros(steps), np.full(steps, HALF_ANGLE)
    for _ in range(50):
        middle = (low + high) / 2.0
        p = printed(belief(distance, middle, REACH, HALF_ANGLE), np.full(steps, region_1))
        right_side = p > 0.5 if region_1 else p < 0.5
        low, high = np.where(right_side, middle, low), np.where(right_side, high, middle)
    return float(np.average(1.0 - low / HALF_ANGLE, weights=distance))


def wrong_part_exactly(nearest: float, farthest: float, threshold: float) -> float:
    """The same, integrated by hand: on the arc at r, the part min(1, r/R + 2 threshold - 1) is wrong."""
    offset = 2.0 * threshold - 1.0
    knee = min(max((1.0 - offset) * REACH, nearest), farthest)
    slanted = (knee**3 - nearest**3) / (3.0 * REACH) + offset * (knee**2 - nearest**2) / 2.0
    return (slanted + (farthest**2 - knee**2) / 2.0) / ((farthest**2 - nearest**2) / 2.0)


@pytest.mark.parametrize(
    ("echo", "region_1", "region_2"),
    [(2.0, 0.22, 0.10), (4.0, 0.42, 0.23), (6.0, 0.62, 0.37), (8.0, 0.82, 0.50), (9.5, 0.97, 0.60)],
)
def test_this_much_of_the_printed_model_has_the_wrong_sign(
    echo: float, region_1: float, region_2: float
) -> None:
    at_echo = wrong_part(echo - TOLERANCE, echo + TOLERANCE, True)
    before = wrong_part(0.0, echo - TOLERANCE, False)
    assert (at_echo, before) == approx((region_1, region_2), abs=0.005)
    assert at_echo == approx(wrong_part_exactly(echo - TOLERANCE, echo + TOLERANCE, 0.5 / 0.98), abs=1e-6)
    assert before == approx(wrong_part_exactly(0.0, echo - TOLERANCE, 0.5), abs=1e-6)
    assert before == approx(2.0 / 3.0 * (echo - TOLERANCE) / REACH, abs=1e-6)


@pytest.mark.parametrize(("detection", "nats", "probability"), SILENCES)
def test_silence_weighs_as_much_as_the_obstacle_would_have_answered(
    detection: float, nats: float, probability: float
) -> None:
    found = no_echo_log_odds(np.array([detection]))[0]
    assert found == approx(nats, abs=1e-6)
    assert sigmoid(found) == approx(probability, abs=1e-6)


def test_two_readings_of_0_7_upon_a_prior_of_0_3() -> None:
    as_likelihoods = posterior(0.7, 0.3, posterior(0.7, 0.3, 0.3))
    as_posteriors = sigmoid(odds(0.3) + 2.0 * (odds(0.7) - odds(0.3)))
    assert as_likelihoods == approx(0.70, abs=1e-6)
    assert as_posteriors == approx(0.9270270, abs=1e-6)


@pytest.mark.parametrize(("floor", "hits"), [(0.001, 9), (0.02, 5), (0.1192, 3)])
def test_so_many_hits_of_0_7_turn_a_cell_over_from_the_floor(floor: float, hits: int) -> None:
    chained, count = floor, 0
    while chained <= 0.5:
        chained, count = posterior(0.7, 0.3, chained), count + 1
    assert count == hits
    assert ceil(-odds(floor) / odds(0.7)) == hits


def test_a_plain_probability_of_0_absorbs_everything() -> None:
    chained = 0.0
    for _ in range(100):
        chained = posterior(0.9, 0.1, chained)
    assert chained == 0.0


def test_plain_certainties_which_contradict_each_other_have_no_answer() -> None:
    with pytest.raises(ZeroDivisionError):
        posterior(0.0, 1.0, 1.0)


def test_the_printed_form_s_hard_zero_can_be_taken_back() -> None:
    assert by_book(printed, 10.0, 15.0, 10.0) == approx(0.0, abs=1e-12)
    assert -7.0 < odds(0.0) < 0.0
