"""A foyer of 16 x 11 m with pillars, a counter and six people who walk about."""

from collections.abc import Sequence

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.motion import Tour
from echogrid.emulation.vista import Point
from echogrid.emulation.walker import WALKING_SPEED, Walker
from echogrid.emulation.worlds.furnishing import Box, Furnishing, Post
from echogrid.emulation.worlds.venue import Venue

_PLAN = FloorPlan(
    floors=((0.0, 0.0, 16.0, 11.0), (6.5, 11.0, 9.5, 11.6), (16.0, 3.0, 16.5, 5.0)),
    furniture=((3.0, 9.6, 5.6, 10.2), (12.6, 10.2, 15.0, 11.0), (0.0, 4.0, 0.7, 6.2)),
    rough=((0.0, 0.0, 0.0, 4.0), (10.0, 0.0, 13.0, 0.0)),
    soft=((0.0, 4.0, 0.7, 6.2, 12.0),),
)
_BOXES = (Box(13.9, 2.2, 1.6, 0.7, 30.0, softness=12.0), Box(2.0, 1.6, 0.7, 0.7, 40.0))
_POSTS = (
    *(Post(x, y, 0.25) for x in (4.6, 8.0, 11.4) for y in (3.4, 7.4)),
    Post(15.4, 6.6, 0.2),
    Post(0.6, 10.4, 0.25),
)
_WAYPOINTS = (
    (1.6, 3.6),
    (3.3, 2.4),
    (6.3, 2.2),
    (6.3, 5.4),
    (9.7, 5.4),
    (9.7, 2.0),
    (12.0, 1.8),
    (12.8, 5.6),
    (14.5, 4.2),
    (14.5, 8.4),
    (13.0, 9.0),
    (9.8, 9.2),
    (9.6, 6.6),
    (6.4, 6.4),
    (6.2, 9.0),
    (2.4, 8.6),
    (1.4, 6.9),
    (3.2, 5.6),
    (7.8, 5.9),
    (3.2, 4.6),
)
_TOUR = Tour(_WAYPOINTS, frozenset({3, 8, 11, 15}))


def _walker(waypoints: Sequence[Point], start: float, radius: float, softness: float) -> Walker:
    """Somebody who is round a whole number of times while the robot is once.

    So whom it does not meet in one lap, it never meets. The speed is as near to the usual one as that allows.
    """
    length = Walker(waypoints).lap_length
    rounds = round(WALKING_SPEED * _TOUR.lap_time / length)
    return Walker(waypoints, start, rounds * length / _TOUR.lap_time, radius, softness)


_WALKERS = (
    _walker(((3.2, 0.7), (15.2, 0.7), (15.2, 1.1), (3.2, 1.1)), 16.5, 0.22, 12.0),
    _walker(((8.0, 10.9), (8.0, 8.4), (12.4, 6.2), (15.8, 4.0), (12.2, 6.4), (7.6, 8.6)), 9.0, 0.2, 10.0),
    _walker(((8.8, 10.5), (12.0, 10.5), (12.0, 10.0), (8.8, 10.1)), 4.0, 0.25, 15.0),
    _walker(((5.6, 7.7), (7.2, 5.0), (9.9, 4.1), (6.9, 5.9)), 10.0, 0.23, 13.0),
    _walker(((1.2, 2.8), (2.9, 6.0), (3.2, 8.8), (2.5, 6.4)), 6.5, 0.21, 11.0),
    _walker(((15.2, 9.4), (15.2, 7.8), (13.6, 7.0), (13.6, 8.2)), 5.5, 0.24, 14.0),
)
"""Nobody runs into anybody."""


def foyer() -> Venue:
    """People cross the robot's way and hide what is behind them."""
    furnishing = Furnishing(boxes=_BOXES, posts=_POSTS, walkers=_WALKERS)
    return Venue(furnishing.world("foyer", _PLAN), _TOUR)
