"""Learning a network from samples, by gradient descent on the log-loss (Adam; Kingma & Ba 2015)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.network import Floats, Network

_BATCH = 512
_RATE = 0.01
_DECAY = 1e-4
"""Keeps weights small that nothing speaks for."""
_MOMENTS = 0.9, 0.999
_LEAST = 1e-8


@dataclass(frozen=True, slots=True)
class Lesson:
    """How it is learned."""

    hidden: int = 12
    """Hidden sums."""
    epochs: int = 20
    """How often all samples are seen."""
    seed: int = 0


def learned(features: Floats, occupied: NDArray[np.bool_], lesson: Lesson) -> Network:
    """The network for samples (n, m) and whether each was occupied (n,); a seed gives the same bits."""
    mean, scale = features.mean(axis=0), features.std(axis=0) + 1e-9
    random = np.random.default_rng(lesson.seed)
    network = _first(mean, scale, lesson.hidden, random)
    x, truth = network.standardised(features), occupied.astype(np.float64)
    weights = [network.direct, network.hidden, network.hidden_bias, network.output, network.bias]
    first = [np.zeros_like(each) for each in weights]
    second = [np.zeros_like(each) for each in weights]
    batches = len(truth) // _BATCH
    for step in range(lesson.epochs * batches):
        if step % batches == 0:
            order = random.permutation(len(truth))
        chosen = order[step % batches * _BATCH :][:_BATCH]
        slopes = _slopes(weights, x[chosen], truth[chosen])
        rate = _RATE * 0.5 * (1.0 + np.cos(np.pi * step / (lesson.epochs * batches)))
        for index, slope in enumerate(slopes):
            first[index] = _MOMENTS[0] * first[index] + (1.0 - _MOMENTS[0]) * slope
            second[index] = _MOMENTS[1] * second[index] + (1.0 - _MOMENTS[1]) * slope**2
            mean_slope = first[index] / (1.0 - _MOMENTS[0] ** (step + 1))
            spread = np.sqrt(second[index] / (1.0 - _MOMENTS[1] ** (step + 1)))
            weights[index] = weights[index] - rate * mean_slope / (spread + _LEAST)
    return Network(mean, scale, *weights)


def _first(mean: Floats, scale: Floats, hidden: int, random: np.random.Generator) -> Network:
    """One that knows nothing."""
    many = len(mean)
    return Network(
        mean,
        scale,
        np.zeros(many),
        random.normal(0.0, many**-0.5, (many, hidden)),
        np.zeros(hidden),
        random.normal(0.0, 0.5 * hidden**-0.5, hidden),
        np.zeros(1),
    )


def _slopes(weights: list[Floats], x: Floats, truth: Floats) -> tuple[Floats, ...]:
    """The log-loss's derivatives by the weights, in their order."""
    direct, hidden, hidden_bias, output, bias = weights
    sums = np.tanh(x @ hidden + hidden_bias)
    probability = 1.0 / (1.0 + np.exp(-(sums @ output + x @ direct + bias)))
    error = (probability - truth) / len(truth)
    back = np.outer(error, output) * (1.0 - sums**2)
    return (
        x.T @ error + _DECAY * direct,
        x.T @ back + _DECAY * hidden,
        back.sum(axis=0),
        sums.T @ error + _DECAY * output,
        np.array([error.sum()]),
    )
