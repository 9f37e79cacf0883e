"""Judges ways of making maps: every theory hears the same pings, and is judged on the same cells."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from time import perf_counter

import numpy as np

from echogrid.emulation.truth import truth
from echogrid.emulation.worlds import WORLDS, Venue
from echogrid.mapping import probability_scores as scores
from echogrid.mapping.cone import cast
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.metrics import Mask, free_recall, quality
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.theory import Theory
from echogrid.runtime.ring_recording import RingPing, record

RESOLUTION_M = 0.1
MARGIN_M = 5.6
"""Around the tour: no ping speaks of more."""
SUREST = 0.01
"""The probabilities of theories that saturate are kept so far from 0 and 1."""
THRESHOLDS = np.arange(1, 20) / 20.0
_TOUCH_EVERY = 61
"""Pings: of so many one is looked at for the cells that it touches; sonars and turns take turns in them."""
_PATH_STEPS = 2000


Maker = Callable[[str, GridGeometry], Theory]
"""From the name of the world in which a theory is judged, in which it may not have learned, and the grid."""


def as_heard(ping: RingPing) -> Sounding:
    """What the ring takes a ping for."""
    return ping.sounding


@dataclass(frozen=True, slots=True)
class Contender:
    """A theory that is judged. All of it can be sent to another process."""

    name: str
    make: Maker
    of_the_book: bool = False
    saturates: bool = True
    """Its probabilities are surer than they can be; for the log-loss they are clipped."""
    threshold: float = 0.5
    """What is likelier to be occupied is called so."""
    hear: Callable[[RingPing], Sounding] = as_heard
    numbers: Mapping[str, Callable[[float], Maker]] | None = None
    """What it is made with, by name: each gives the maker that has so many times as much of it. None: its
    sensitivity is not looked at."""


@dataclass(frozen=True, slots=True)
class Trial:
    """A lap through a world, and what is true there. Masks are (rows, cols)."""

    world: str
    geometry: GridGeometry
    pings: tuple[RingPing, ...]
    walls: Mask
    judged: Mask


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a theory in a trial: the scores of probability_scores.py and metrics.py."""

    score: float
    score_per_cell: float
    nats: float
    bits: float
    skill: float
    brier: float
    auc: float
    average_precision: float
    calibration_error: float
    correlation: float
    map_score: float
    f1: float
    """At the theory's threshold, as the following."""
    precision: float
    recall: float
    overlap: float
    phantoms: float
    missed: float
    free_recall: float
    best_f1: float
    """At the best of all thresholds."""
    cells_per_ping: float
    """Cells of which a ping speaks to an empty map."""
    microseconds_per_ping: float


Standings = dict[str, list[list[Verdict]]]
"""By the name of the contender: a row for each world, in it one verdict for each seed."""


def arena(venue: Venue) -> GridGeometry:
    """The grid over all that a ring of sonars may see on a lap."""
    times = np.linspace(0.0, venue.tour.lap_time, _PATH_STEPS)
    path = np.array([venue.tour.pose(time_s)[:2] for time_s in times])
    west, south = path.min(axis=0) - MARGIN_M
    east, north = path.max(axis=0) + MARGIN_M
    return GridGeometry.covering(west, south, east, north, RESOLUTION_M)


def judged_cells(venue: Venue, geometry: GridGeometry) -> tuple[Mask, Mask]:
    """(rows, cols) which cells hold a surface, and which can be judged: those, and the free and reachable."""
    x, y, _ = venue.tour.pose(0.0)
    walls, free = truth(venue.world, geometry.x_centres, geometry.y_centres, (x, y))
    return walls, walls | free


def spoken_of(geometry: GridGeometry, heard: Iterable[Sounding]) -> Mask:
    """(rows, cols) the cells in region I or II of at least one echo; what silence says is too little."""
    mask = np.zeros(geometry.shape, np.bool_)
    for sounding in heard:
        if sounding.echo is not None:
            cone = cast(geometry, sounding)
            mask[cone.rows, cone.cols] = True
    return mask


def trial(world: str, seed: int) -> Trial:
    """One lap."""
    venue = WORLDS[world]()
    geometry = arena(venue)
    pings = tuple(record(venue, seed))
    walls, possible = judged_cells(venue, geometry)
    heard = spoken_of(geometry, (ping.sounding for ping in pings))
    return Trial(world, geometry, pings, walls, possible & heard)


def judge(contender: Contender, at: Trial) -> Verdict:
    """Let a theory hear the pings, and judge its map."""
    heard = [contender.hear(ping) for ping in at.pings]
    theory = contender.make(at.world, at.geometry)
    started = perf_counter()
    for sounding in heard:
        theory.update(sounding)
    seconds = perf_counter() - started
    touched = [_touched(contender.make(at.world, at.geometry), each) for each in heard[::_TOUCH_EVERY]]
    return _verdict(contender, at, theory, (float(np.mean(touched)), 1e6 * seconds / len(heard)))


def standings(
    worlds: Sequence[str], seeds: Sequence[int], contenders: Sequence[Contender], processes: int = 2
) -> Standings:
    """Judge all of them in every world with every seed, in so many processes."""
    trials = [(world, seed) for world in worlds for seed in seeds]
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        verdicts = list(pool.map(partial(_judge_all, contenders), trials))
    return {
        contender.name: [
            [verdicts[row * len(seeds) + col][index] for col in range(len(seeds))]
            for row in range(len(worlds))
        ]
        for index, contender in enumerate(contenders)
    }


def _judge_all(contenders: Sequence[Contender], lap: tuple[str, int]) -> list[Verdict]:
    at = trial(*lap)
    return [judge(contender, at) for contender in contenders]


def _touched(empty: Theory, sounding: Sounding) -> int:
    empty.update(sounding)
    return int(np.count_nonzero(~empty.unknown()))


def _verdict(contender: Contender, at: Trial, theory: Theory, cost: tuple[float, float]) -> Verdict:
    image, known = theory.occupancy().astype(np.float64), ~theory.unknown()
    probability, occupied = image[at.judged], at.walls[at.judged]
    sure = np.clip(probability, SUREST, 1.0 - SUREST) if contender.saturates else probability
    called = quality((image > contender.threshold) & known, at.walls, at.judged)
    nats = scores.log_loss(sure, occupied)
    return Verdict(
        score=scores.book_score(probability, occupied),
        score_per_cell=scores.book_score(probability, occupied) / len(probability),
        nats=nats,
        bits=nats / scores.NATS_IN_A_BIT,
        skill=scores.skill(sure, occupied),
        brier=scores.brier(probability, occupied),
        auc=scores.area_under_curve(probability, occupied),
        average_precision=scores.average_precision(probability, occupied),
        calibration_error=scores.calibration_error(probability, occupied),
        correlation=scores.correlation(probability, occupied),
        map_score=scores.map_score(sure, occupied),
        f1=called.f1,
        precision=called.precision,
        recall=called.recall,
        overlap=called.overlap,
        phantoms=called.phantoms,
        missed=called.missed,
        free_recall=free_recall((image < contender.threshold) & known, at.walls, at.judged),
        best_f1=max(quality((image > each) & known, at.walls, at.judged).f1 for each in THRESHOLDS),
        cells_per_ping=cost[0],
        microseconds_per_ping=cost[1],
    )
