"""A world to be driven through, and where in it a robot may start and be sent to."""

from collections.abc import Sequence
from typing import NamedTuple

from echogrid.emulation.floor_plan import Rectangle
from echogrid.emulation.vista import Point
from echogrid.emulation.world import World


class Arena(NamedTuple):
    """Where avoidance is tried."""

    world: World
    inside: Point
    """A free place on the floor, m: what connects to it can be reached."""
    starts: Sequence[Rectangle] = ()
    """Where the robot may start; nothing: anywhere."""
    goals: Sequence[Rectangle] = ()
    """Where it may be sent to; nothing: anywhere."""
