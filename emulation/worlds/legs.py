"""A canteen of 12 x 8 m: tables of four legs, chairs of four, and nothing else between its walls."""

from collections.abc import Iterator
from math import cos, radians, sin

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.worlds.arena import Arena
from echogrid.emulation.worlds.furnishing import Furnishing, Post

_TABLE = (1.4, 0.8, 0.025)
"""Length, width and the radius of a leg, m."""
_CHAIR = (0.42, 0.42, 0.012)
_TABLES = ((3.2, 1.8, 0.0), (3.4, 5.6, 12.0), (6.2, 3.6, 90.0), (8.9, 1.7, -8.0), (9.0, 5.8, 5.0))
"""Middle, m, and turn, deg."""
_CHAIRS = (
    (3.0, 2.6, 10.0),
    (3.6, 0.9, -5.0),
    (2.9, 4.7, 30.0),
    (4.2, 6.5, 0.0),
    (5.3, 3.4, 80.0),
    (7.1, 4.0, 95.0),
    (8.5, 2.6, 0.0),
    (9.4, 0.8, 20.0),
    (8.8, 4.9, -12.0),
    (9.8, 6.8, 45.0),
    (6.2, 6.6, 60.0),
    (6.0, 1.2, 15.0),
)
_PLAN = FloorPlan(
    floors=((0.0, 0.0, 12.0, 8.0),),
    furniture=((0.0, 7.4, 2.4, 8.0),),
    rough=((12.0, 0.0, 12.0, 8.0),),
)


def _legs(place: tuple[float, float, float], size: tuple[float, float, float]) -> Iterator[Post]:
    """The four legs of something at a place."""
    x, y, turn_deg = place
    length, width, radius = size
    c, s = cos(radians(turn_deg)), sin(radians(turn_deg))
    for ahead in (-0.5 * length, 0.5 * length):
        for left in (-0.5 * width, 0.5 * width):
            yield Post(x + ahead * c - left * s, y + ahead * s + left * c, radius)


_POSTS = (
    *(leg for table in _TABLES for leg in _legs(table, _TABLE)),
    *(leg for chair in _CHAIRS for leg in _legs(chair, _CHAIR)),
)


def legs() -> Arena:
    """A leg of 2.4 cm returns little, and only where the beam is strong."""
    world = Furnishing(posts=_POSTS).world("legs", _PLAN, 21.0)
    return Arena(world, (1.2, 4.0), ((0.6, 1.0, 1.6, 6.8),), ((10.6, 1.0, 11.4, 7.0),))
