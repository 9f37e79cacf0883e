"""An empirical sonar model of a log, and what it is worth on the half of it that it was not counted in."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.cone import cast
from echogrid.mapping.empirical_model import Bins, Empirical, Tally
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.metrics import Mask
from echogrid.mapping.probability_scores import base_log_loss, log_loss, skill
from echogrid.mapping.sonar_model import NoEcho, SonarModel, evidence
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.theories import MAP_LIMIT
from echogrid.runtime.reference_map import LoggedPing
from echogrid.runtime.truth_map import TruthMap

Floats = NDArray[np.float64]

FACTORS = tuple(float(each) for each in np.geomspace(0.003, 1.0, 26))
"""Pings that follow each other are worth a twentieth to a fifth of independent ones, as a rule."""
FEWEST_CELLS = 200
"""Of a half, known and spoken of: on fewer nothing is judged."""
OFFSETS = (-4.0, -2.0, -1.0, -0.5, -0.3, -0.2, -0.12, -0.04, 0.04, 0.12, 0.2)
"""m: for cells of 5 to 10 cm."""
_BEARINGS = _READINGS = 8


@dataclass(frozen=True, slots=True)
class Half:
    """Pings, and the map by which they are judged."""

    pings: tuple[Sounding, ...]
    truth: TruthMap


@dataclass(frozen=True, slots=True)
class Skills:
    """Of maps by one model or another: 1 - log-loss/log-loss of the base rate, the mean of both halves."""

    configured: float
    found: float
    """Of the configured model with the half angle that was found."""
    empirical: float
    """Counted and tempered in the other half."""


@dataclass(frozen=True, slots=True)
class ModelTrial:
    """The model, and how it did."""

    model: Empirical
    """Tempered."""
    factor: float
    pings: int
    cells: int
    """That were judged, of both halves' maps."""
    skills: Skills


@dataclass(frozen=True, slots=True)
class Beliefs:
    """What is thought before, and what was found of the beam."""

    model: SonarModel
    no_echo: NoEcho
    half_angle: float
    """rad, as it was found."""


def bins(half_angle: float, reach: float) -> Bins:
    """As wide as the beam (rad), as far as the reach (m)."""
    bearings = tuple(float(each) for each in np.linspace(0.0, half_angle, _BEARINGS + 1))
    return Bins(OFFSETS, bearings, tuple(float(each) for each in np.linspace(0.0, reach, _READINGS + 1)))


def halves(pings: Sequence[LoggedPing], maps: tuple[TruthMap, TruthMap], tolerance: float) -> list[Half]:
    """The pings of even and of odd stretches."""
    result = []
    for parity, truth in enumerate(maps):
        chosen = [ping for ping in pings if ping.stretch % 2 == parity]
        soundings = (
            Sounding(ping.transducer, ping.ranger, ping.echo, ping.ranger.tolerance or tolerance)
            for ping in chosen
        )
        result.append(Half(tuple(soundings), truth))
    return result


def tried(parts: Sequence[Half], beliefs: Beliefs) -> ModelTrial | None:
    """The model of both halves, judged by models of one on the other; None: there is too little to judge."""
    reach = max((ping.ranger.farthest for part in parts for ping in part.pings), default=1.0)
    tallies = [_counted(part, bins(beliefs.half_angle, reach)) for part in parts]
    judged = [_judged(part, other.model(), beliefs) for part, other in zip(parts, tallies[::-1], strict=True)]
    if any(each is None for each in judged):
        return None
    cells = [each for each in judged if each is not None]
    crossed = zip(cells, cells[::-1], strict=True)
    skills = Skills(
        float(np.mean([each.configured for each in cells])),
        float(np.mean([each.found for each in cells])),
        float(np.mean([one.skill(other.best_factor()) for one, other in crossed])),
    )
    tally = tallies[0]
    tally.echo += tallies[1].echo
    tally.silence += tallies[1].silence
    model = tally.model()
    factor = min(FACTORS, key=lambda each: sum(one.loss(each) for one in cells))
    count = sum(len(each.occupied) for each in cells)
    pings = sum(len(part.pings) for part in parts)
    return ModelTrial(model.tempered(factor), factor, pings, count, skills)


@dataclass(frozen=True, slots=True)
class _Judged:
    """What a model says of the cells of a half, (n,), which are truly occupied or not."""

    sums: Floats
    """nats, untempered."""
    occupied: Mask
    configured: float
    found: float

    def probability(self, factor: float) -> Floats:
        """(n,) P(Occupied) of the tempered model."""
        sums = np.clip(factor * self.sums, -MAP_LIMIT, MAP_LIMIT)
        result: Floats = 1.0 / (1.0 + np.exp(-sums))
        return result

    def loss(self, factor: float) -> float:
        """Nats a cell, over those of the base rate."""
        return log_loss(self.probability(factor), self.occupied) / base_log_loss(self.occupied)

    def skill(self, factor: float) -> float:
        return skill(self.probability(factor), self.occupied)

    def best_factor(self) -> float:
        return min(FACTORS, key=self.loss)


def _counted(part: Half, within: Bins) -> Tally:
    tally = Tally(within)
    truth = part.truth
    for ping in part.pings:
        cone = cast(truth.geometry, within.believed(ping))
        walls, free = truth.walls[cone.rows, cone.cols], truth.free[cone.rows, cone.cols]
        tally.add(cone, walls, walls | free)
    return tally


def _judged(part: Half, model: Empirical, beliefs: Beliefs) -> _Judged | None:
    geometry = part.truth.geometry
    sums, spoken = np.zeros(geometry.shape), np.zeros(geometry.shape, np.bool_)
    for ping in part.pings:
        cone = cast(geometry, model.believed(ping))
        sums[cone.rows, cone.cols] += evidence(cone, model, beliefs.no_echo)
        spoken[cone.rows, cone.cols] = True
    wider = [_with_half_angle(ping, beliefs.half_angle) for ping in part.pings]
    maps = [_fused(geometry, pings, beliefs) for pings in (part.pings, wider)]
    cells = spoken & (part.truth.walls | part.truth.free)
    for each in maps:
        cells &= ~each.unknown()
    occupied = part.truth.walls[cells]
    if len(occupied) < FEWEST_CELLS or occupied.all() or not occupied.any():
        return None
    scores = [skill(each.occupancy()[cells].astype(np.float64), occupied) for each in maps]
    return _Judged(sums[cells], occupied, *scores)


def _fused(geometry: GridGeometry, pings: Sequence[Sounding], beliefs: Beliefs) -> BayesGrid:
    grid = BayesGrid(geometry, MAP_LIMIT, beliefs.model, beliefs.no_echo)
    for ping in pings:
        grid.update(ping)
    return grid


def _with_half_angle(ping: Sounding, half_angle: float) -> Sounding:
    return replace(ping, ranger=replace(ping.ranger, half_angle=half_angle))
