"""A world and a round through it."""

from typing import NamedTuple

from echogrid.emulation.motion import Tour
from echogrid.emulation.world import World


class Venue(NamedTuple):
    """Where a robot is judged, and how it drives there."""

    world: World
    tour: Tour
    """Begins at a place which is free."""
