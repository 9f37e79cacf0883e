from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pytest import approx

from echogrid.mapping.network import Network
from echogrid.mapping.network_training import Lesson, _first, _slopes, learned

RANDOM = np.random.default_rng(3)


def noisy(number: int) -> tuple[Any, Any]:
    """Samples of a rule that no plane can tell: occupied where the product is positive, most of the time."""
    features = RANDOM.normal(size=(number, 3))
    likely = 1.0 / (1.0 + np.exp(-4.0 * features[:, 0] * features[:, 1]))
    return features, RANDOM.random(number) < likely


@given(arrays(np.float64, (5, 3), elements=st.floats(-1e9, 1e9)))
def test_no_features_are_too_strange(features: Any) -> None:
    network = _first(np.zeros(3), np.ones(3), 4, np.random.default_rng(0))
    assert np.all(np.isfinite(network.log_odds(features)))


def test_the_slopes_are_those_of_the_log_loss() -> None:
    x, truth = RANDOM.normal(size=(40, 3)), (RANDOM.random(40) < 0.5).astype(float)
    network = _first(np.zeros(3), np.ones(3), 4, np.random.default_rng(0))
    weights = [
        RANDOM.normal(size=getattr(network, name).shape)
        for name in ("direct", "hidden", "hidden_bias", "output", "bias")
    ]

    def loss(changed: list[Any]) -> float:
        direct, hidden, hidden_bias, output, bias = changed
        odds = x @ direct + np.tanh(x @ hidden + hidden_bias) @ output + bias
        decay = sum(0.5e-4 * np.sum(each**2) for each in (direct, hidden, output))
        return float(np.mean(np.logaddexp(0.0, odds) - truth * odds) + decay)

    for index, slope in enumerate(_slopes(weights, x, truth)):
        for place in np.ndindex(slope.shape):
            up, down = ([each.copy() for each in weights] for _ in range(2))
            up[index][place] += 1e-6
            down[index][place] -= 1e-6
            assert slope[place] == approx((loss(up) - loss(down)) / 2e-6, abs=1e-7)


def test_it_learns_what_no_plane_can_tell_and_how_sure_one_can_be() -> None:
    network = learned(*noisy(20_000), Lesson(hidden=8, epochs=15))
    features, occupied = noisy(20_000)
    said = 1.0 / (1.0 + np.exp(-network.log_odds(features)))
    for low in np.arange(0.0, 1.0, 0.2):
        within = (said >= low) & (said < low + 0.2)
        assert np.mean(occupied[within]) == approx(np.mean(said[within]), abs=0.05)
    assert np.mean((said > 0.5) == occupied) > 0.75


def test_the_same_seed_learns_the_same_bits() -> None:
    samples = noisy(2_000)
    one, two = (learned(*samples, Lesson(4, 3, seed=5)) for _ in range(2))
    assert np.array_equal(one.hidden, two.hidden)
    assert not np.array_equal(one.hidden, learned(*samples, Lesson(4, 3, seed=6)).hidden)


def test_a_network_is_what_its_numbers_say() -> None:
    numbers = {
        "mean": "1.0",
        "scale": "2.0",
        "direct": "0.5",
        "hidden": "1.0 -1.0",
        "hidden_bias": "0.0 0.5",
        "output": "2.0 3.0",
        "bias": "0.25",
    }
    odds = Network.of(numbers).log_odds(np.array([[3.0]]))
    assert odds == approx([0.5 + 2.0 * np.tanh(1.0) + 3.0 * np.tanh(-0.5) + 0.25])
