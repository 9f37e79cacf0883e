"""How likely a wall is heard so far off a ranger's axis, and where that axis is, by maximum likelihood."""

from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, replace
from math import log, radians, sqrt

import numpy as np

from echogrid.mapping.wall_trials import Floats, Trials

_HALF_ANGLES = radians(2.0), radians(55.0)
_FADINGS = 0.0, 0.5
_BLURS = radians(1.0) ** 2, radians(30.0) ** 2
_TOPS = 0.1, 1.0
_FLOORS = 0.0, 0.5
_START = radians(20.0), 0.02, radians(12.0) ** 2, 0.9, 0.05
_STEPS = radians(4.0), 0.02, radians(6.0) ** 2, 0.05, 0.02
_LOWEST, _HIGHEST = 0.02, 0.98
"""Of probabilities: one surprise is not the end."""
_YAWS = np.radians(np.arange(-20.0, 20.01, 0.25))
"""rad: how far an axis may be off where it is looked for."""
_HALVES = np.radians(np.arange(2.0, 55.01, 0.5))
_FINEST = 1.0 / 64.0
"""Of the first steps."""


@dataclass(frozen=True, slots=True)
class BeamProfile:
    """p = floor + (top - floor)/(1 + exp(-(half_angle^2 - fading ln(r/middle) - alpha^2)/blur)).

    A Gaussian beam's echo loses so many dB as alpha^2 grows, and as ln r grows; it is heard while it is above
    the threshold, within the noise of its level.
    """

    half_angle: float
    """rad: half of the walls are heard there that are `middle` away."""
    fading: float
    """rad^2."""
    blur: float
    """rad^2."""
    top: float
    """The part of walls on the axis that are heard."""
    floor: float
    """The part that seems heard far off it: by chance."""
    middle: float
    """m."""

    def detection(self, bearing: Floats, distance: Floats) -> Floats:
        """(..., n) the probability that a wall so far off the axis (rad) and away (m) answers."""
        above = self.half_angle**2 - self.fading * np.log(distance / self.middle) - bearing**2
        heard = 1.0 / (1.0 + np.exp(np.clip(-above / self.blur, -40.0, 40.0)))
        result: Floats = np.clip(self.floor + (self.top - self.floor) * heard, _LOWEST, _HIGHEST)
        return result

    def half_angle_at(self, distance: float) -> float:
        """rad: half of the walls in that distance (m) are heard there; 0: not even on the axis."""
        return sqrt(max(self.half_angle**2 - self.fading * log(distance / self.middle), 0.0))

    def likelihood(self, trials: Trials, yaw: Floats | float = 0.0) -> Floats:
        """(...) ln of the likelihood of trials, all decided, if the axis is `yaw` (...) to the left."""
        bearing = trials.bearing - np.asarray(yaw)[..., np.newaxis]
        detection = self.detection(bearing, trials.distance)
        logs = np.where(trials.heard, np.log(detection), np.log1p(-detection))
        total: Floats = logs @ trials.weight
        return total


def fitted(trials: Trials, start: BeamProfile | None = None) -> BeamProfile:
    """The likeliest profile of trials, all decided, whose bearings are from the true axis."""
    middle = start.middle if start else float(np.median(trials.distance))
    first = astuple(start)[:-1] if start else _START

    def made(values: Sequence[float]) -> BeamProfile:
        half_angle, fading, blur, top, floor = values
        return BeamProfile(half_angle, fading, blur, top, floor, middle)

    def score(values: Sequence[float]) -> float:
        return float(made(values).likelihood(trials))

    bounds = _HALF_ANGLES, _FADINGS, _BLURS, _TOPS, _FLOORS
    return made(_climbed(score, first, _STEPS, bounds))


def yaw_of(trials: Trials, profile: BeamProfile) -> float:
    """rad: how far to the left of where it is thought to be the axis most likely is."""
    return _peak(_YAWS, profile.likelihood(trials, _YAWS))


def half_angle_of(trials: Trials, profile: BeamProfile) -> float:
    """rad: the likeliest half angle where all else is as in the profile."""
    scores = [replace(profile, half_angle=half).likelihood(trials) for half in _HALVES]
    return _peak(_HALVES, np.array(scores))


def _peak(places: Floats, scores: Floats) -> float:
    """Where the best score is, between the places: by a parabola through it and its neighbours."""
    best = int(np.argmax(scores))
    if not 0 < best < len(places) - 1:
        return float(places[best])
    before, here, after = scores[best - 1 : best + 2]
    bend = before - 2.0 * here + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return float(places[best] + shift * (places[1] - places[0]))


def _climbed(
    score: Callable[[Sequence[float]], float],
    start: Sequence[float],
    steps: Sequence[float],
    bounds: Sequence[tuple[float, float]],
) -> list[float]:
    """The values of the best score near the start: one at a time, by steps that are halved when none helps
    (Hooke & Jeeves 1961)."""
    values, best = list(start), score(start)
    sizes = list(steps)
    while max(size / step for size, step in zip(sizes, steps, strict=True)) > _FINEST:
        before = best
        for index, (low, high) in enumerate(bounds):
            for step in (sizes[index], -sizes[index]):
                tried = [*values]
                tried[index] = min(max(values[index] + step, low), high)
                if (found := score(tried)) > best:
                    values, best = tried, found
                    break
        if best == before:
            sizes = [size / 2.0 for size in sizes]
    return values
