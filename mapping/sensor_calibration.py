"""What rangers of one kind are truly like, from pings that were put to the test against a map.

Their beam and noise are found together, each one's own axis and bias beside them. How sure each number is, is
told by the bootstrap over stretches of time: pings of one stretch are no independent witnesses.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf, radians

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping import beam_profile, range_noise
from echogrid.mapping.beam_profile import BeamProfile
from echogrid.mapping.range_noise import RangeNoise, Residuals
from echogrid.mapping.wall_trials import Floats, Trials

VIEWS_OF_A_KIND = 100
"""Views of walls that answered, and as many of walls that did not: fewer make no profile."""
VIEWS_OF_A_SENSOR = 30
"""The same for the axis of one ranger, when the profile is known."""
FEWEST_PAIRS = 100
"""Readings that can be compared with the one before."""
FEWEST_OF_A_WALL = 50
"""Readings of walls by one ranger, to tell its bias."""
FEWEST_ECHOES = 200
"""Of which to tell the share of false ones."""
BEARINGS = tuple(radians(degrees) for degrees in (0.0, 10.0, 20.0, 30.0, 40.0, 60.0))
"""rad: the borders of the table of silence."""
DISTANCES = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, inf)
"""m."""

_ROUNDS = 3
"""The profile needs the axes, these the profile."""
_SAMPLES = 50
_BESIDE = radians(5.0)
"""A surface so far beyond the beam may still be what answered."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number, and its standard error."""

    value: float
    error: float


@dataclass(frozen=True, slots=True)
class TooFew:
    """Why nothing is claimed."""

    what: str
    found: int
    needed: int


Found = Estimate | TooFew


@dataclass(frozen=True, slots=True)
class Noise:
    """How readings of walls scatter."""

    model: RangeNoise
    near: Estimate
    growth: Estimate
    pairs: int
    farthest: float
    """m: nine in ten of the walls that answered were nearer."""


@dataclass(frozen=True, slots=True)
class Beam:
    """Where walls are heard."""

    profile: BeamProfile
    half_angle: Estimate
    """rad, at the profile's middle distance."""
    silence: Floats
    """(bearings, distances) the part of pings without any echo by where the wall is; NaN: too few views."""


@dataclass(frozen=True, slots=True)
class Own:
    """What was found of one ranger."""

    sensor: int
    pings: int
    silent: float
    """The part of them that came back with nothing."""
    heard: float
    """Views of walls that answered."""
    missed: float
    yaw: Found
    """rad, to the left of where its axis is thought to be."""
    half_angle: Found
    """rad."""
    bias: Found
    """m: by how much it tells more than there is."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """All that was found of rangers of one kind."""

    pings: int
    silent: float
    beam: Beam | TooFew
    noise: Noise | TooFew
    false_echoes: Found
    """The part of echoes which no surface explains."""
    own: tuple[Own, ...]


@dataclass(frozen=True, slots=True)
class _Fit:
    """A profile, and the axes that go with it."""

    profile: BeamProfile
    yaws: Floats
    """(sensors,) rad; 0 for those with too few views."""
    halves: Floats
    """(sensors,) rad, each one's own."""


def calibrated(pings: Trials, thought: float, random: np.random.Generator) -> Calibration:
    """What pings of rangers of one kind tell; they are in the order of time. `thought` (rad) is their half
    angle as it is configured."""
    decided = pings.take(pings.on_trial)
    beam, axes = _beam(decided, [int(each) for each in np.unique(pings.sensor)], random)
    heard_to = beam.profile.half_angle if isinstance(beam, Beam) else thought
    found = range_noise.residuals(pings)
    own = tuple(_own(pings, sensor, *axis, found, random) for sensor, axis in axes.items())
    yaws = {each.sensor: each.yaw.value for each in own if isinstance(each.yaw, Estimate)}
    single = pings.take(pings.first)
    return Calibration(
        len(single.sensor),
        float(np.isnan(single.reading).mean()),
        beam,
        _noise(found, random),
        _false_echoes(single, heard_to + _BESIDE, yaws, random),
        own,
    )


def _beam(
    decided: Trials, sensors: Sequence[int], random: np.random.Generator
) -> tuple[Beam | TooFew, dict[int, tuple[Found, Found]]]:
    """The beam, and each one's yaw and half angle."""
    if short := _shortage(decided, VIEWS_OF_A_KIND):
        return short, dict.fromkeys(sensors, (short, short))
    fit = _fit(decided, None)
    samples = [_fit(decided.take(index), fit) for index in _resampled(decided.stretch, random)]
    axes: dict[int, tuple[Found, Found]] = {}
    for sensor in sensors:
        views = decided.take(decided.sensor == sensor)
        axes[sensor] = (
            _shortage(views, VIEWS_OF_A_SENSOR)
            or Estimate(float(fit.yaws[sensor]), _spread([each.yaws[sensor] for each in samples])),
            _shortage(views, VIEWS_OF_A_KIND)
            or Estimate(float(fit.halves[sensor]), _spread([each.halves[sensor] for each in samples])),
        )
    error = _spread([each.profile.half_angle for each in samples])
    half_angle = Estimate(fit.profile.half_angle, error)
    centred = replace(decided, bearing=decided.bearing - fit.yaws[decided.sensor])
    return Beam(fit.profile, half_angle, _silence(centred)), axes


def _fit(decided: Trials, start: _Fit | None) -> _Fit:
    """The profile and the axes, in turn; from where another one began, once."""
    yaws = start.yaws if start else np.zeros(int(decided.sensor.max()) + 1)
    profile = start.profile if start else None
    for _ in range(1 if start else _ROUNDS):
        centred = replace(decided, bearing=decided.bearing - yaws[decided.sensor])
        profile = beam_profile.fitted(centred, profile)
        yaws = _each(decided, np.zeros(len(yaws)), profile, beam_profile.yaw_of)
    centred = replace(decided, bearing=decided.bearing - yaws[decided.sensor])
    profile = beam_profile.fitted(centred, profile)
    halves = _each(centred, np.full(len(yaws), profile.half_angle), profile, beam_profile.half_angle_of)
    return _Fit(profile, yaws, halves)


def _each(
    decided: Trials, unknown: Floats, profile: BeamProfile, find: Callable[[Trials, BeamProfile], float]
) -> Floats:
    """(sensors,) a number of each ranger with enough views, else what stands for it."""
    result = unknown
    for sensor in range(len(result)):
        own = decided.take(decided.sensor == sensor)
        if not _shortage(own, VIEWS_OF_A_SENSOR):
            result[sensor] = find(own, profile)
    return result


def _own(
    pings: Trials,
    sensor: int,
    yaw: Found,
    half_angle: Found,
    residuals: Residuals,
    random: np.random.Generator,
) -> Own:
    mine = pings.take(pings.sensor == sensor)
    readings = mine.reading[mine.first]
    return Own(
        sensor,
        len(readings),
        float(np.isnan(readings).mean()),
        *_views(mine.take(mine.on_trial)),
        yaw,
        half_angle,
        _bias(residuals.take(residuals.sensor == sensor), random),
    )


def _bias(found: Residuals, random: np.random.Generator) -> Found:
    if len(found.off) < FEWEST_OF_A_WALL:
        return TooFew("readings of walls", len(found.off), FEWEST_OF_A_WALL)
    samples = [float(np.median(found.off[index])) for index in _resampled(found.stretch, random)]
    return Estimate(float(np.median(found.off)), _spread(samples))


def _silence(centred: Trials) -> Floats:
    table = np.full((len(BEARINGS) - 1, len(DISTANCES) - 1), np.nan)
    silent = np.isnan(centred.reading)
    row = np.searchsorted(BEARINGS, np.abs(centred.bearing), "right") - 1
    col = np.searchsorted(DISTANCES, centred.distance, "right") - 1
    for place in np.ndindex(table.shape):
        here = (row == place[0]) & (col == place[1])
        weight = centred.weight[here]
        if weight.sum() >= VIEWS_OF_A_SENSOR / 3:
            table[place] = np.average(silent[here], weights=weight)
    return table


def _noise(found: Residuals, random: np.random.Generator) -> Noise | TooFew:
    if found.pairs < FEWEST_PAIRS:
        return TooFew("pairs of readings of a wall", found.pairs, FEWEST_PAIRS)
    model = range_noise.fitted(found)
    samples = [range_noise.fitted(found.take(index)) for index in _resampled(found.stretch, random)]
    near = Estimate(model.near, _spread([each.near for each in samples]))
    growth = Estimate(model.growth, _spread([each.growth for each in samples]))
    return Noise(model, near, growth, found.pairs, float(np.quantile(found.distance, 0.9)))


def _false_echoes(
    pings: Trials, heard_to: float, yaws: dict[int, float], random: np.random.Generator
) -> Found:
    echoes = pings.take(~np.isnan(pings.reading))
    if len(echoes.sensor) < FEWEST_ECHOES:
        return TooFew("echoes", len(echoes.sensor), FEWEST_ECHOES)
    off = np.array([abs(yaws.get(int(sensor), 0.0)) for sensor in echoes.sensor])
    false = echoes.agreeing > heard_to + off
    samples = [float(false[index].mean()) for index in _resampled(echoes.stretch, random)]
    return Estimate(float(false.mean()), _spread(samples))


def _resampled(stretch: NDArray[np.intp], random: np.random.Generator) -> list[NDArray[np.intp]]:
    """The indices of as many stretches as there are, drawn with replacement, many times."""
    members = [np.nonzero(stretch == each)[0] for each in np.unique(stretch)]
    drawn = random.integers(len(members), size=(_SAMPLES, len(members)))
    return [np.sort(np.concatenate([members[each] for each in one])) for one in drawn]


def _shortage(decided: Trials, needed: int) -> TooFew | None:
    heard, missed = _views(decided)
    if heard < needed:
        return TooFew("views of walls that answered", int(heard), needed)
    return TooFew("views of walls that did not answer", int(missed), needed) if missed < needed else None


def _views(decided: Trials) -> tuple[float, float]:
    heard = decided.heard
    return float(decided.weight[heard].sum()), float(decided.weight[~heard].sum())


def _spread(values: Sequence[float]) -> float:
    return float(np.std(values, ddof=1))
