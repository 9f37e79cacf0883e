"""Learning the networks that judge evidence, in the worlds made for it, and writing down their numbers."""

import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from math import radians
from pathlib import Path
from textwrap import wrap

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.transducers import TRANSDUCERS
from echogrid.emulation.worlds.school import school
from echogrid.mapping.calibrated import Judge, in_context, spoken_of
from echogrid.mapping.evidence import CellEvidence
from echogrid.mapping.evidence_features import own_features
from echogrid.mapping.network import Floats, Network
from echogrid.mapping.network_training import Lesson, learned
from echogrid.runtime.map_suite import RESOLUTION_M, arena, judged_cells
from echogrid.runtime.ring_recording import POLAROID, Sonar, soundings

WORLDS = 128
LOOKS = (0.003, 250), (0.02, 250), (0.1, 250), (0.3, 250), (1.0, 2000)
"""How much of the lap has been heard when a map is looked at, and from how many cells it is learned then."""
LESSON = Lesson(hidden=10, epochs=20, seed=1)
OTHERS = (
    Sonar(TRANSDUCERS["a02yyuw"], radians(8.0), 2.5),
    Sonar(TRANSDUCERS["srf08"], radians(15.0), 3.0),
    Sonar(TRANSDUCERS["a02yyuw"], radians(15.0), 3.0),
)
"""So that what is learned is not the one beam."""
DIGITS = 4
"""Of each number that is shipped."""
WIDTH = 105
"""Of its lines."""


@dataclass(frozen=True, slots=True)
class Look:
    """One look at a map."""

    told: NDArray[np.float32]
    """(n, m) of each known cell."""
    known: NDArray[np.bool_]
    """(rows, cols)."""
    chosen: NDArray[np.intp]
    """(k,) the cells that are learned from, by their number among the known ones."""
    occupied: NDArray[np.bool_]
    """(k,)."""


def sonar_of(seed: int) -> Sonar:
    """What the ring of a world is made of: Polaroids, in each fourth world others, told to be narrower."""
    turn, other = divmod(seed, 4)
    return OTHERS[turn % len(OTHERS)] if other == 3 else POLAROID


def looks(seed: int) -> list[Look]:
    """What a ring of sonars tells of a world made by chance in the course of a lap, and what is true.

    A map is looked at long before the lap is over: what little it knows then must be calibrated, too.
    """
    venue = school(seed)
    geometry = arena(venue)
    walls, judged = judged_cells(venue, geometry)
    heard = soundings(venue, seed, sonar_of(seed))
    evidence, random, taken = CellEvidence(geometry), np.random.default_rng(seed), []
    ends = [round(part * len(heard)) for part, _ in LOOKS]
    for (start, end), (_, cells) in zip(pairwise([0, *ends]), LOOKS, strict=True):
        for sounding in heard[start:end]:
            evidence.add(sounding)
        known = spoken_of(evidence)
        told = own_features(evidence.statistics, geometry.resolution)[known].astype(np.float32)
        chosen = random.choice(np.flatnonzero(judged[known]), cells)
        taken.append(Look(told, known, chosen, walls[known][chosen]))
    return taken


def taught(all_looks: Sequence[Look], lesson: Lesson = LESSON) -> Judge:
    """The networks: the second one learns from what the first one says, the third from the second."""
    occupied = np.concatenate([each.occupied for each in all_looks])
    told = [each.told for each in all_looks]
    own = _shortened(learned(_samples(told, all_looks), occupied, lesson))
    told = [_in_context(own, before, each) for before, each in zip(told, all_looks, strict=True)]
    context = _shortened(learned(_samples(told, all_looks), occupied, lesson))
    told = [_in_context(context, before, each) for before, each in zip(told, all_looks, strict=True)]
    return Judge(own, context, _shortened(learned(_samples(told, all_looks), occupied, lesson)))


def learn(worlds: int = WORLDS) -> Judge:
    """All of it, in as many processes as there are cores."""
    with ProcessPoolExecutor() as pool:
        return taught([look for world in pool.map(looks, range(worlds)) for look in world])


def write(judge: Judge, path: Path) -> None:
    """The numbers, as the module that ships with the program."""
    path.write_text("".join(f"{line}\n" for line in _module(judge)), encoding="utf-8")


def _in_context(network: Network, told: NDArray[np.float32], each: Look) -> NDArray[np.float32]:
    """What the next network is told of a look of which this one was told that."""
    log_odds = np.zeros(each.known.shape)
    log_odds[each.known] = network.log_odds(told.astype(np.float64))
    return in_context(each.told.astype(np.float64), each.known, log_odds, RESOLUTION_M).astype(np.float32)


def _samples(told: Sequence[NDArray[np.float32]], all_looks: Sequence[Look]) -> Floats:
    chosen = [features[each.chosen] for features, each in zip(told, all_looks, strict=True)]
    return np.concatenate(chosen).astype(np.float64)


def _shortened(network: Network) -> Network:
    """The same with no more digits than are shipped."""
    return Network.of({name: _text(array) for name, array in network.numbers().items()})


def _text(array: Floats) -> str:
    return " ".join(f"{number:.{DIGITS}g}" for number in array.ravel())


def _module(judge: Judge) -> Iterator[str]:
    yield '"""The numbers of the networks that judge evidence, written by `make learn`: not to be edited."""'
    for name, network in zip(("OWN", "CONTEXT", "AGAIN"), judge, strict=True):
        yield ""
        yield f"{name} = {{"
        for field, array in network.numbers().items():
            yield f'    "{field}": """'
            yield from wrap(_text(array), WIDTH, initial_indent=" " * 8, subsequent_indent=" " * 8)
            yield '    """,'
        yield "}"


if __name__ == "__main__":
    write(learn(), Path(sys.argv[1]))
