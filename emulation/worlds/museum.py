"""A museum of 18 x 12 m: screens at all angles, show cases, statues, cords, and two visitors."""

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.motion import Tour
from echogrid.emulation.walker import Walker
from echogrid.emulation.worlds.furnishing import Box, Furnishing, Post
from echogrid.emulation.worlds.venue import Venue

_PLAN = FloorPlan(
    floors=(
        (0.0, 0.0, 10.9, 7.0),  # great gallery
        (11.1, 0.0, 18.0, 5.4),  # cabinet
        (11.1, 5.6, 18.0, 12.0),  # hall of statues
        (0.0, 7.2, 10.9, 12.0),  # textiles
        (10.9, 2.0, 11.1, 3.4),  # doorways from here on
        (14.0, 5.4, 15.4, 5.6),
        (10.9, 8.8, 11.1, 10.2),
        (4.4, 7.0, 5.8, 7.2),
    ),
    furniture=(
        (0.0, 3.0, 0.5, 4.4),  # show cases along the walls
        (7.0, 0.0, 9.0, 0.5),
        (12.6, 0.0, 16.4, 0.4),
        (17.5, 1.2, 18.0, 3.6),
        (16.0, 11.4, 18.0, 12.0),
    ),
    rough=(
        (0.0, 12.0, 6.0, 12.0),  # tapestries
        (0.0, 8.4, 0.0, 12.0),
        (18.0, 7.0, 18.0, 10.0),  # rubble wall
    ),
    soft=((0.0, 12.0, 6.0, 12.0, 12.0), (0.0, 8.4, 0.0, 12.0, 12.0)),
)
_SCREENS = ((2.2, 1.4, 3.4, 2.8), (6.0, 4.4, 8.2, 5.2), (8.6, 2.2, 9.2, 3.6), (3.7, 9.6, 4.9, 9.1))
_BOXES = (
    Box(5.2, 2.4, 1.4, 0.7, 20.0),  # glass cases
    Box(2.4, 5.2, 1.0, 1.0, 45.0),
    Box(14.4, 2.6, 1.8, 0.8, -12.0),
    Box(7.4, 9.6, 2.0, 0.9, 8.0),
    Box(1.8, 10.4, 1.6, 0.5, 80.0, softness=12.0),  # bench
    Box(13.0, 8.2, 0.9, 0.9, 30.0),  # plinths
    Box(16.0, 8.6, 0.7, 0.7, 10.0),
)
_POSTS = (
    Post(12.6, 10.8, 0.3),  # statues
    Post(14.6, 10.6, 0.22),
    Post(16.8, 6.6, 0.35),
    Post(12.2, 6.4, 0.18),
    *(Post(x, 6.6, 0.025) for x in (6.8, 7.8, 8.8, 9.8)),  # stands of a cord
    *(Post(9.6, y, 0.025) for y in (11.0, 11.5)),
    Post(0.5, 6.5, 0.2, softness=10.0),  # a keeper's chair
)
_WALKERS = (
    Walker(((11.8, 4.5), (13.6, 4.6), (13.6, 4.9), (11.8, 4.8)), start=3.0, radius=0.22, softness=12.0),
    Walker(((6.4, 11.4), (8.9, 11.3), (8.6, 10.9), (6.6, 10.9)), start=0.0, radius=0.24, softness=14.0),
)
_WAYPOINTS = (
    (1.2, 2.0),
    (1.2, 0.8),
    (4.2, 0.9),
    (6.6, 1.2),
    (7.4, 2.6),
    (7.6, 3.6),
    (9.9, 4.4),
    (10.0, 2.7),
    (12.2, 2.7),
    (12.4, 1.4),
    (16.4, 1.2),
    (16.6, 3.2),
    (14.7, 4.0),
    (14.7, 6.8),
    (14.6, 8.8),
    (15.4, 9.6),
    (13.4, 9.5),
    (9.4, 9.5),
    (9.2, 8.2),
    (5.8, 8.2),
    (5.6, 10.8),
    (3.2, 11.0),
    (3.0, 8.2),
    (5.1, 8.0),
    (5.1, 5.6),
    (4.0, 4.0),
    (1.4, 3.9),
)


def museum() -> Venue:
    """Screens under odd angles, soft and rough and shiny. Nothing was tuned on it."""
    furnishing = Furnishing(_SCREENS, _BOXES, _POSTS, _WALKERS)
    return Venue(furnishing.world("museum", _PLAN, 19.0), Tour(_WAYPOINTS, frozenset({2, 10, 14, 20, 25})))
