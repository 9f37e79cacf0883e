"""The four facts that a distance can be."""

from math import inf, isnan, nan

import pytest

from echogrid.drivers.readings import Outcome, classify


@pytest.mark.parametrize(
    ("distance", "outcome"),
    [
        (0.0, Outcome.TOO_CLOSE),
        (0.0999, Outcome.TOO_CLOSE),
        (-inf, Outcome.TOO_CLOSE),
        (0.1, Outcome.ECHO),
        (3.999, Outcome.ECHO),
        (4.0, Outcome.NO_ECHO),
        (inf, Outcome.NO_ECHO),
        (nan, Outcome.INVALID),
    ],
)
def test_only_a_distance_within_reach_is_an_echo_and_only_an_echo_has_a_distance(
    distance: float, outcome: Outcome
) -> None:
    found, kept = classify(distance, 0.1, 4.0)
    assert found is outcome
    assert kept == distance if outcome is Outcome.ECHO else isnan(kept)
