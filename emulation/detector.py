"""How a receiver finds an echo: by a threshold, in noise."""

from collections.abc import Sequence

import numpy as np

from echogrid.emulation.scene import Echo

LEVEL_NOISE = 2.0
"""dB, standard deviation."""
RANGE_NOISE = 0.005
"""m, standard deviation, and in proportion to the range:"""
RANGE_NOISE_RATIO = 0.01
LATE_AT_THRESHOLD = 0.02
"""m: a faint echo crosses the threshold late, this much when it just does."""
DROPOUT = 0.02
"""The part of pings of which nothing is heard."""
_LUCK = 5.0 * LEVEL_NOISE
"""dB: noise lifts nothing over the threshold that is fainter than this; it would in one of 3 million."""


class Detector:
    """The detector of one receiver. Without a generator it knows neither noise nor dropout."""

    def __init__(self, sensitivity: float, rng: np.random.Generator | None) -> None:
        self.sensitivity = sensitivity
        """dB that a sound which is just heard without noise has lost."""
        self.faintest = sensitivity + (0.0 if rng is None else _LUCK)
        """dB that a sound which is ever heard has lost."""
        self._rng = rng

    def misses(self) -> bool:
        """Whether it is deaf to a ping."""
        return self._rng is not None and self._rng.random() < DROPOUT

    def margins(self, losses: Sequence[float]) -> list[float]:
        """By how much sounds that have lost so much, dB, are above the threshold this time, dB."""
        noises = self._noise(len(losses))
        return [
            self.sensitivity - loss + LEVEL_NOISE * noise for loss, noise in zip(losses, noises, strict=True)
        ]

    def timed(self, heard: Sequence[Echo], ways: Sequence[float]) -> list[Echo]:
        """The echoes at the distances which it finds; `ways` has half of the way that each went, m."""
        if self._rng is None:
            return list(heard)
        noises = self._noise(len(heard))
        return [_late(*found) for found in zip(heard, ways, noises, strict=True)]

    def _noise(self, count: int) -> list[float]:
        """Samples of the standard normal distribution, or zeros."""
        if self._rng is None or not count:
            return [0.0] * count
        samples: list[float] = self._rng.standard_normal(count).tolist()
        return samples


def _late(echo: Echo, way: float, noise: float) -> Echo:
    """An echo as it is timed, with a standard normal sample."""
    spread = RANGE_NOISE + RANGE_NOISE_RATIO * way
    late = LATE_AT_THRESHOLD * 10.0 ** (-echo.margin / 20.0)
    return Echo(max(echo.distance + spread * noise + late, 0.0), echo.margin, echo.kind)
