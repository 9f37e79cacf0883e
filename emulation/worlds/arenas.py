"""The worlds in which avoidance is tried: the frozen ones, and what drives robots into trouble."""

from collections.abc import Callable, Mapping
from functools import partial

from echogrid.emulation.worlds.arena import Arena
from echogrid.emulation.worlds.catalogue import WORLDS
from echogrid.emulation.worlds.dead_ends import dead_ends
from echogrid.emulation.worlds.legs import legs
from echogrid.emulation.worlds.mirrors import mirrors
from echogrid.emulation.worlds.narrow_doors import narrow_doors
from echogrid.emulation.worlds.passers_by import passers_by
from echogrid.emulation.worlds.traps import traps
from echogrid.emulation.worlds.venue import Venue


def _frozen(venue: Callable[[], Venue]) -> Arena:
    world, tour = venue()
    x, y, _ = tour.pose(0.0)
    return Arena(world, (x, y))


ARENAS: Mapping[str, Callable[[], Arena]] = {
    **{name: partial(_frozen, venue) for name, venue in WORLDS.items()},
    "narrow-doors": narrow_doors,
    "traps": traps,
    "dead-ends": dead_ends,
    "mirrors": mirrors,
    "passers-by": passers_by,
    "legs": legs,
}
