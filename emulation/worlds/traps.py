"""A hall of 14 x 9 m with three U-shaped traps, whose mouths are turned towards whoever comes."""

from echogrid.emulation.floor_plan import FloorPlan, Rectangle
from echogrid.emulation.worlds.arena import Arena
from echogrid.emulation.worlds.furnishing import Furnishing, Post

_THICK = 0.1
"""m, of the walls of a trap."""


def _trap(west: float, south: float, east: float, north: float) -> tuple[Rectangle, ...]:
    """Its two sides and its bottom, in the east."""
    return (
        (west, south, east, south + _THICK),
        (west, north - _THICK, east, north),
        (east - _THICK, south, east, north),
    )


_PLAN = FloorPlan(
    floors=((0.0, 0.0, 14.0, 9.0),),
    furniture=(
        *_trap(3.0, 3.0, 5.0, 6.0),
        *_trap(7.0, 0.9, 8.6, 3.1),
        *_trap(7.2, 5.4, 9.6, 8.0),
        (0.0, 0.0, 0.6, 1.6),
    ),
    rough=((14.0, 0.0, 14.0, 9.0),),
)
_POSTS = (Post(10.8, 4.4, 0.15), Post(6.0, 7.6, 0.08))


def traps() -> Arena:
    """The straight way to the goal leads into a trap, and the way out of it away from the goal."""
    world = Furnishing(posts=_POSTS).world("traps", _PLAN)
    return Arena(world, (1.5, 4.5), ((1.0, 3.2, 2.2, 5.8),), ((11.6, 2.0, 13.2, 7.2),))
