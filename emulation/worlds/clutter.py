"""A hall of 14 x 10 m full of crates at all angles, and posts."""

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.motion import Tour
from echogrid.emulation.worlds.furnishing import Box, Furnishing, Post
from echogrid.emulation.worlds.venue import Venue

_PLAN = FloorPlan(
    floors=((0.0, 0.0, 14.0, 10.0),),
    furniture=((0.0, 4.6, 0.4, 6.4), (6.2, 9.5, 8.4, 10.0), (13.2, 0.0, 14.0, 1.0)),
    rough=((14.0, 1.0, 14.0, 5.0),),
)
_BOXES = (
    Box(2.9, 2.6, 1.6, 1.1, 25.0),
    Box(6.2, 2.3, 1.2, 1.2, 50.0),
    Box(9.3, 2.7, 1.8, 0.9, -35.0),
    Box(12.2, 3.4, 1.0, 1.0, 12.0),
    Box(3.0, 6.2, 1.4, 1.0, -60.0),
    Box(6.5, 5.9, 1.6, 1.2, 8.0),
    Box(10.1, 6.3, 1.7, 1.2, 40.0),
    Box(1.9, 8.9, 1.0, 0.6, 70.0),
    Box(4.9, 8.2, 0.8, 0.7, 33.0),
    Box(12.9, 8.6, 1.1, 0.7, 65.0),
)
_POSTS = (
    Post(0.6, 0.7, 0.15),
    Post(4.6, 0.4, 0.06),
    Post(7.8, 4.2, 0.1),
    Post(11.0, 0.5, 0.15),
    Post(13.4, 5.8, 0.05),
    Post(9.6, 8.6, 0.2),
    Post(0.5, 7.4, 0.04),
)
_WAYPOINTS = (
    (1.3, 4.2),
    (1.3, 1.3),
    (4.4, 1.2),
    (4.6, 3.9),
    (5.0, 4.4),
    (7.2, 4.2),
    (7.8, 3.2),
    (7.7, 1.1),
    (10.3, 1.2),
    (11.0, 2.0),
    (10.9, 4.4),
    (9.0, 4.5),
    (8.6, 5.6),
    (8.5, 7.5),
    (10.2, 8.0),
    (11.2, 9.2),
    (11.6, 6.8),
    (12.5, 6.4),
    (12.4, 4.7),
    (11.4, 4.8),
    (9.0, 4.7),
    (8.2, 7.6),
    (6.2, 7.7),
    (5.9, 9.15),
    (3.2, 9.3),
    (3.3, 7.8),
    (4.7, 7.1),
    (4.6, 4.7),
    (2.6, 4.5),
    (1.4, 5.0),
    (1.2, 7.0),
    (1.3, 7.7),
    (1.2, 6.0),
)


def clutter() -> Venue:
    """Corners and edges everywhere, and walls that are soon over."""
    world = Furnishing(boxes=_BOXES, posts=_POSTS).world("clutter", _PLAN)
    return Venue(world, Tour(_WAYPOINTS, frozenset({3, 8, 13, 18, 24, 27})))
