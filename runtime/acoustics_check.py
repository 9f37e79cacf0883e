"""How deceptive the emulated acoustics are: what a ring of sonars hears on a round through each world.

Smooth walls that are met at a slant answer nothing, or by way of mirrors. The ring is the usual one of
sixteen, each a Polaroid which listens to 5 m; they fire one after the other.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import cos, pi, sin

from echogrid.emulation.acoustics import Transducer
from echogrid.emulation.hearing import Outing, Ranger, scene_of
from echogrid.emulation.scene import Kind
from echogrid.emulation.transducers import POLAROID
from echogrid.emulation.worlds import WORLDS, Venue

SONARS = 16
REACH_M = 5.0
RING_RADIUS_M = 0.25
SONAR = replace(POLAROID, reach=REACH_M)
_GAP_NS = 35_000_000
_SECOND_NS = 1_000_000_000
_KINDS = tuple(kind.name.lower() for kind in Kind if kind is not Kind.CROSSTALK)


@dataclass(frozen=True, slots=True)
class Shares:
    """What came back first, as parts of all pings."""

    pings: int
    no_echo: float
    first: dict[str, float]
    """By the kind of echo: "wall", "bounce" (by way of mirrors) and so on."""


def ring(sonar: Transducer = SONAR) -> list[Ranger]:
    """The sonars, all around a robot."""
    bearings = [2.0 * pi * index / SONARS for index in range(SONARS)]
    return [
        Ranger(f"ring_{index}", (RING_RADIUS_M * cos(b), RING_RADIUS_M * sin(b), b), sonar)
        for index, b in enumerate(bearings)
    ]


def outcome_shares(venue: Venue, seed: int, every_s: float = 1.0) -> Shares:
    """Once around the world, with a round of pings every so many seconds."""
    outing = Outing(venue.world, lambda now_ns: venue.tour.pose(now_ns / _SECOND_NS), seed)
    scenes = [scene_of(outing, ranger) for ranger in ring()]
    first: Counter[str] = Counter()
    for round_number in range(int(venue.tour.lap_time / every_s)):
        start_ns = round(round_number * every_s * _SECOND_NS)
        for index, scene in enumerate(scenes):
            echoes = scene(start_ns + index * _GAP_NS)
            first[echoes[0].kind if echoes else "none"] += 1
    pings = first.total()
    return Shares(pings, first["none"] / pings, {kind: first[kind] / pings for kind in _KINDS})


def table(seed: int, every_s: float = 1.0) -> Iterator[str]:
    """Rows of Markdown: the shares in every world."""
    yield f"| world | pings | no echo | {' | '.join(_KINDS)} |"
    yield "|---|" + "---|" * (len(_KINDS) + 2)
    for name, venue in WORLDS.items():
        shares = outcome_shares(venue(), seed, every_s)
        parts = [shares.no_echo, *shares.first.values()]
        yield f"| {name} | {shares.pings} | {' | '.join(f'{100.0 * part:.1f} %' for part in parts)} |"
