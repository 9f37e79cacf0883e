import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping import range_noise
from echogrid.mapping.range_noise import RangeNoise, residuals
from echogrid.mapping.wall_trials import Trials


def heard(noise: RangeNoise, seed: int, count: int = 3000, walls_off: float = 0.0) -> Trials:
    """Echoes of a wall to which a ranger drives and back again, ten a second."""
    random = np.random.default_rng(seed)
    number = np.arange(count)
    distance = 1.5 + np.sin(0.01 * number)
    spread = np.array([noise.sigma(each) for each in distance])
    reading = distance + walls_off + spread * random.standard_normal(count)
    ones = np.ones(count)
    return Trials(
        np.zeros(count, np.intp),
        number * 100_000_000,
        number // 100,
        reading,
        ones,
        np.zeros(count),
        distance,
        np.full(count, 0.2),
        ones,
        np.ones(count, np.bool_),
    )


@settings(deadline=None, max_examples=20)
@given(st.floats(0.002, 0.02), st.floats(0.0, 0.02), st.floats(-0.08, 0.08), st.integers(0, 99))
def test_the_noise_is_found_wherever_the_map_has_its_walls(
    near: float, growth: float, walls_off: float, seed: int
) -> None:
    true = RangeNoise(near, growth)
    found = range_noise.fitted(residuals(heard(true, seed, walls_off=walls_off)))
    for distance in (0.6, 1.5, 2.4):
        assert found.sigma(distance) == pytest.approx(true.sigma(distance), rel=0.15)
    assert found.near >= 0.0
    assert found.growth >= 0.0


def test_readings_of_the_wall_are_compared_with_the_one_before_if_that_was_soon() -> None:
    trials = heard(RangeNoise(0.01, 0.0), 1, 10)
    assert residuals(trials).pairs == 9
    gap = trials.stamp_ns + np.where(np.arange(10) >= 5, 5_000_000_000, 0)
    late = Trials(trials.sensor, gap, *(getattr(trials, name) for name in _REST))
    assert residuals(late).pairs == 8


_REST = (
    "stretch",
    "reading",
    "agreeing",
    "bearing",
    "distance",
    "tolerance",
    "weight",
    "first",
)


def test_what_is_not_heard_has_no_residual() -> None:
    trials = heard(RangeNoise(0.01, 0.0), 1, 10)
    trials.reading[3] = np.nan
    assert len(residuals(trials).off) == 9
