"""How much a map depends on numbers that somebody chose: each turned down and up by a quarter."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.sounding import Sounding
from echogrid.runtime.map_suite import Contender, Standings, standings
from echogrid.runtime.ring_recording import RingPing

Floats = NDArray[np.float64]

FACTORS = (0.75, 1.25)


@dataclass(frozen=True, slots=True)
class Sway:
    """What becomes of a map if one number of its theory is a quarter lower and higher."""

    theory: str
    parameter: str
    changes: tuple[float, ...]
    """For each of the factors: of F1; where nothing is known to be true, how far P(Occupied) of a cell is
    moved, on the mean."""

    @property
    def largest(self) -> float:
        """The larger change, without its sign."""
        return max(abs(change) for change in self.changes)


@dataclass(frozen=True, slots=True)
class MeanSway(Sway):
    """That of F1 on the mean over several worlds."""

    worst_world: float
    """The largest change in a world, without its sign."""


def scaled_beam(factor: float, ping: RingPing) -> Sounding:
    """The ping, believed to be so many times as wide (beta)."""
    ranger = ping.sounding.ranger
    return replace(ping.sounding, ranger=replace(ranger, half_angle=ranger.half_angle * factor))


def scaled_tolerance(factor: float, ping: RingPing) -> Sounding:
    """The ping, its band believed to be so many times as thick."""
    return replace(ping.sounding, tolerance=ping.sounding.tolerance * factor)


def turned(contender: Contender) -> Mapping[str, tuple[Contender, ...]]:
    """By parameter, the contender with that turned down and up; each has its own name."""
    heard = {"beta": scaled_beam, "tolerance": scaled_tolerance}
    variants = {
        parameter: tuple(replace(contender, hear=partial(scaled, factor)) for factor in FACTORS)
        for parameter, scaled in heard.items()
    } | {
        parameter: tuple(replace(contender, make=maker(factor)) for factor in FACTORS)
        for parameter, maker in (contender.numbers or {}).items()
    }
    return {
        parameter: tuple(
            replace(variant, name=f"{contender.name}, {factor:g} {parameter}")
            for factor, variant in zip(FACTORS, pair, strict=True)
        )
        for parameter, pair in variants.items()
    }


def sways(
    worlds: Sequence[str], seed: int, contenders: Sequence[Contender], processes: int
) -> list[MeanSway]:
    """For each contender that has numbers, and each parameter, in one lap through each world."""
    contenders = [contender for contender in contenders if contender.numbers is not None]
    table = {contender.name: turned(contender) for contender in contenders}
    variants = [variant for pairs in table.values() for pair in pairs.values() for variant in pair]
    found = standings(worlds, (seed,), [*contenders, *variants], processes)
    return [
        _sway(name, parameter, _f1(found, name), [_f1(found, variant.name) for variant in pair])
        for name, pairs in table.items()
        for parameter, pair in pairs.items()
    ]


def _sway(theory: str, parameter: str, usual: Floats, others: Sequence[Floats]) -> MeanSway:
    changes = [other - usual for other in others]
    means = tuple(float(change.mean()) for change in changes)
    return MeanSway(theory, parameter, means, max(float(np.abs(change).max()) for change in changes))


def _f1(found: Standings, name: str) -> Floats:
    """(worlds,)."""
    return np.array([row[0].f1 for row in found[name]])
