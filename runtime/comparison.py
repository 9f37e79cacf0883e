"""Every theory on the pings of one log, at the log's poses: their maps, how good and how alike they are."""

from collections.abc import Callable
from dataclasses import dataclass
from math import radians
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.long_term_map import MapImage
from echogrid.mapping.metrics import Mask, quality
from echogrid.mapping.probability_scores import FLAT
from echogrid.mapping.theory import Theory, layers
from echogrid.runtime.compared_theories import OCCUPIED, contenders
from echogrid.runtime.comparison_steering import TRUTH, Steered, steered
from echogrid.runtime.echo_tape import echo_ends, play
from echogrid.runtime.errors import UsageError
from echogrid.runtime.map_suite import Contender, Trial, Verdict, judge, spoken_of
from echogrid.runtime.recording import Recording
from echogrid.runtime.sensitivity import FACTORS, Sway, turned
from echogrid.runtime.stationary import CELLS, Moved, moved

Floats = NDArray[np.float64]
Say = Callable[[str], None]

_WIDEST = radians(90.0) / max(FACTORS)
"""A cone wider than that can't be turned up."""


class Truth(Protocol):
    """What is true of the place."""

    def lattice(self, area: GridGeometry) -> GridGeometry:
        """The cells over that area in which it can be told."""
        ...

    def on(self, lattice: GridGeometry) -> tuple[Mask, Mask]:
        """(rows, cols) walls, and free cells."""
        ...


@dataclass(frozen=True, slots=True)
class Finding:
    """A theory's map and what is to be said of it."""

    name: str
    occupancy: Floats
    """(rows, cols) P(Occupied), row 0 = south; 0.5 where unknown."""
    unknown: Mask
    verdict: Verdict
    """Without a truth, only what it says of costs."""
    conflict: Floats | None
    """(rows, cols) nats, the sum of the weights of conflict; None: the theory knows none."""
    stationary: tuple[Moved, ...]
    """A robot that stands, for each of the cells of stationary.py."""
    sways: tuple[Sway, ...]


@dataclass(frozen=True, slots=True)
class Comparison:
    """All that the report tells."""

    geometry: GridGeometry
    pings: int
    echoes: int
    echo_ends: Mask
    walls: Mask | None
    """None: the truth is not known."""
    judged: Mask
    """Cells of which an echo has spoken, and the truth, if there is one."""
    findings: tuple[Finding, ...]
    path: tuple[tuple[float, float], ...]
    """m, where the robot was."""
    steered: Steered
    """What steering would decide on each of the maps."""


def compare(recording: Recording, truth: Truth | None, names: tuple[str, ...], say: Say) -> Comparison:
    """Every theory of those names on a recording's pings; `say` is told what is being done.

    Raises UsageError when there is nothing to compare by: no poses, no echo, a truth of elsewhere.
    """
    area, pings = play(recording)
    geometry = truth.lattice(area) if truth else area
    soundings = [ping.sounding for ping in pings]
    heard = spoken_of(geometry, soundings)
    if not heard.any():
        raise UsageError(["no echo at any pose: there is nothing to compare"])
    walls, told = _truth_on(truth, geometry, heard)
    judged = heard & told
    trial = Trial("the log", geometry, pings, walls, judged)
    rivals = contenders(names, recording.config.map.no_echo, max(ping.speed for ping in pings) or 1.0)
    findings = tuple(_find(rival, trial, truth is not None, say) for rival in rivals)
    maps = {TRUTH: MapImage(geometry, walls.astype(np.float32), ~told)} if truth else {}
    for found in findings:
        maps[found.name] = MapImage(geometry, found.occupancy.astype(np.float32), found.unknown)
    return Comparison(
        geometry,
        len(pings),
        sum(sounding.echo is not None for sounding in soundings),
        echo_ends(geometry, soundings),
        walls if truth else None,
        judged,
        findings,
        tuple((pose.x, pose.y) for _, pose in recording.poses),
        steered(recording.config, recording.poses, maps),
    )


def agreement(comparison: Comparison) -> Floats:
    """(n, n) Pearson's r between the maps of the theories, on the judged cells; 0 for one that is the same
    everywhere, to within `FLAT`."""
    maps = np.stack([finding.occupancy[comparison.judged] for finding in comparison.findings])
    off = np.where(np.ptp(maps, axis=1, keepdims=True) < FLAT, 0.0, maps - maps.mean(axis=1, keepdims=True))
    spread = np.sqrt((off**2).sum(axis=1))
    result: Floats = off @ off.T / np.maximum(np.outer(spread, spread), np.finfo(np.float64).tiny)
    return result


def apart(comparison: Comparison, one: str, other: str) -> float | None:
    """How far two maps are apart on the mean over the judged cells; None: not both are there."""
    found = {finding.name: finding.occupancy[comparison.judged] for finding in comparison.findings}
    if one not in found or other not in found:
        return None
    return float(np.abs(found[one] - found[other]).mean())


def _truth_on(truth: Truth | None, geometry: GridGeometry, heard: Mask) -> tuple[Mask, Mask]:
    """Walls, and the cells of which the truth is known, or none is needed."""
    if truth is None:
        return np.zeros(geometry.shape, np.bool_), np.ones(geometry.shape, np.bool_)
    walls, free = truth.on(geometry)
    for name, cells in (("wall", walls), ("free cell", free)):
        if not (heard & cells).any():
            told = f"the truth has no {name} where the log heard anything"
            raise UsageError([f"{told}: is it of another place, or in another frame?"])
    return walls, walls | free


def _find(contender: Contender, trial: Trial, true: bool, say: Say) -> Finding:
    say(contender.name)
    theory = _heard(contender, trial)
    conflict = layers(theory).get("conflict")
    return Finding(
        contender.name,
        theory.occupancy().astype(np.float64),
        theory.unknown(),
        judge(contender, trial),
        None if conflict is None else conflict.astype(np.float64),
        tuple(moved(contender, trial.world, cell) for cell in CELLS.values()),
        tuple(_sways(contender, trial, theory, true)),
    )


def _heard(contender: Contender, trial: Trial) -> Theory:
    """The theory after all pings."""
    theory = contender.make(trial.world, trial.geometry)
    for ping in trial.pings:
        theory.update(contender.hear(ping))
    return theory


def _sways(contender: Contender, trial: Trial, usual: Theory, true: bool) -> list[Sway]:
    """Of every number of the theory; the threshold is one if there is something to judge by."""
    if contender.numbers is None:
        return []
    measure = _f1_change if true else _moved_by
    widest = max(ping.sounding.ranger.half_angle for ping in trial.pings)
    sways = [
        Sway(
            contender.name,
            parameter,
            tuple(measure(trial, usual, _heard(variant, trial)) for variant in pair),
        )
        for parameter, pair in turned(contender).items()
        if parameter != "beta" or widest < _WIDEST
    ]
    if true:
        f1s = [_f1(trial, usual, factor * OCCUPIED) for factor in FACTORS]
        sways.append(Sway(contender.name, "threshold", tuple(f1 - _f1(trial, usual) for f1 in f1s)))
    return sways


def _f1_change(trial: Trial, usual: Theory, other: Theory) -> float:
    return _f1(trial, other) - _f1(trial, usual)


def _f1(trial: Trial, theory: Theory, threshold: float = OCCUPIED) -> float:
    called = (theory.occupancy() > threshold) & ~theory.unknown()
    return quality(called, trial.walls, trial.judged).f1


def _moved_by(trial: Trial, usual: Theory, other: Theory) -> float:
    return float(np.abs(other.occupancy() - usual.occupancy())[trial.judged].mean())
