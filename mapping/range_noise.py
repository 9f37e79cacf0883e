"""How far a ranger's readings scatter about the walls that they are of, robustly."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.wall_trials import Floats, Index, Trials

_TO_SIGMA = 1.4826
"""A normal distribution's standard deviation over its median absolute deviation."""
_LONGEST_NS = 1_000_000_000
"""Readings further apart are not compared: the wall may have changed."""
_BANDS = 6
"""Of range, with equally many readings."""
_LEAST = 0.002
"""m: sigma is never believed to be below."""


@dataclass(frozen=True, slots=True)
class RangeNoise:
    """sigma = near + growth r, m."""

    near: float
    growth: float

    def sigma(self, distance: float) -> float:
        """m."""
        return max(self.near + self.growth * distance, _LEAST)


@dataclass(frozen=True, slots=True)
class Residuals:
    """Readings less the distances of the walls that answered; arrays of shape (n,)."""

    sensor: NDArray[np.intp]
    stretch: NDArray[np.intp]
    distance: Floats
    """m: of the wall."""
    off: Floats
    """m."""
    step: Floats
    """m: how much it is more than that of the ranger's ping before; NaN where they can't be compared."""

    def take(self, index: Index) -> "Residuals":
        """Some of them."""
        return Residuals(
            self.sensor[index], self.stretch[index], self.distance[index], self.off[index], self.step[index]
        )

    @property
    def pairs(self) -> int:
        """How many can be compared with the one before."""
        return int(np.count_nonzero(~np.isnan(self.step)))


def residuals(trials: Trials) -> Residuals:
    """Of all trials whose wall answered; they are in the order of time."""
    heard = trials.take(trials.on_trial & trials.heard)
    off = heard.reading - heard.distance
    step = np.full(len(off), np.nan)
    for sensor in np.unique(heard.sensor):
        own = np.nonzero(heard.sensor == sensor)[0]
        soon = np.diff(heard.stamp_ns[own]) <= _LONGEST_NS
        alike = np.abs(np.diff(heard.distance[own])) <= heard.tolerance[own][1:]
        step[own[1:]] = np.where(soon & alike, np.diff(off[own]), np.nan)
    return Residuals(heard.sensor, heard.stretch, heard.distance, off, step)


def fitted(found: Residuals) -> RangeNoise:
    """From the differences of successive readings, in which the map's own errors cancel."""
    paired = found.take(~np.isnan(found.step))
    near, growth = _line(paired.distance, np.abs(paired.step))
    spread = _TO_SIGMA / np.sqrt(2.0)
    return RangeNoise(spread * near, spread * growth)


def _line(distance: Floats, values: Floats) -> tuple[float, float]:
    """Value at zero and slope, none below 0, of a line through the medians of bands of equally many."""
    order = np.argsort(distance, kind="stable")
    bands = [band for band in np.array_split(order, _BANDS) if len(band)]
    x = np.array([np.median(distance[band]) for band in bands])
    y = np.array([np.median(values[band]) for band in bands])
    centred = x - x.mean()
    spread = float(centred @ centred)
    slope = max(float(centred @ y) / spread, 0.0) if spread > 0.0 else 0.0
    zero = float(y.mean() - slope * x.mean())
    return (zero, slope) if zero >= 0.0 else (0.0, float(y.mean() / x.mean()))
