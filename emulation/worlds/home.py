"""A flat of 11 x 9.6 m with upholstery, curtains and the legs of tables and chairs."""

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.motion import Tour
from echogrid.emulation.worlds.furnishing import Box, Furnishing, Post
from echogrid.emulation.worlds.venue import Venue

_PLAN = FloorPlan(
    floors=(
        (0.0, 0.0, 6.0, 5.0),  # living room
        (6.1, 0.0, 11.0, 5.0),  # kitchen
        (0.0, 5.1, 11.0, 6.4),  # hall
        (0.0, 6.5, 4.4, 9.6),  # bedroom
        (4.5, 6.5, 6.9, 9.6),  # bath
        (7.0, 6.5, 11.0, 9.6),  # study
        (4.4, 5.0, 5.4, 5.1),  # doorways from here on
        (9.2, 5.0, 10.2, 5.1),
        (6.0, 2.6, 6.1, 3.6),
        (2.6, 6.4, 3.6, 6.5),
        (5.0, 6.4, 6.0, 6.5),
        (8.2, 6.4, 9.2, 6.5),
    ),
    furniture=(
        (0.0, 1.2, 0.9, 3.4),  # living room: sofa, sideboard, television
        (1.6, 4.6, 3.6, 5.0),
        (2.4, 0.0, 4.4, 0.4),
        (6.1, 0.0, 11.0, 0.6),  # kitchen: worktop, refrigerator
        (10.3, 0.6, 11.0, 1.3),
        (10.3, 5.1, 11.0, 5.5),  # hall: wardrobe
        (0.0, 7.2, 2.0, 8.8),  # bedroom: bed, wardrobe
        (3.8, 8.0, 4.4, 9.6),
        (4.5, 8.8, 6.9, 9.6),  # bath: tub, basin
        (6.4, 7.0, 6.9, 7.6),
        (9.4, 9.0, 11.0, 9.6),  # study: desk, shelves
        (7.0, 7.2, 7.3, 9.6),
    ),
    rough=(
        (0.0, 0.0, 0.0, 1.0),  # curtains
        (4.6, 0.0, 6.0, 0.0),
        (0.6, 9.6, 2.6, 9.6),
        (11.0, 7.0, 11.0, 8.4),
        (7.3, 7.2, 7.3, 9.6),  # backs of books
    ),
    soft=(
        (0.0, 1.2, 0.9, 3.4, 12.0),
        (0.0, 7.2, 2.0, 8.8, 14.0),
        (0.0, 0.0, 0.0, 1.0, 10.0),
        (4.6, 0.0, 6.0, 0.0, 10.0),
        (0.6, 9.6, 2.6, 9.6, 10.0),
        (11.0, 7.0, 11.0, 8.4, 10.0),
    ),
)
_BOXES = (Box(4.9, 1.2, 0.8, 0.8, 35.0, softness=12.0), Box(9.9, 8.0, 0.5, 0.5, 20.0, softness=11.0))
"""Armchair, desk chair."""
_POSTS = (
    *(Post(x, y, 0.03) for x in (1.7, 2.6) for y in (1.9, 2.7)),  # coffee table
    *(Post(x, y, 0.03) for x in (8.0, 9.2) for y in (2.2, 3.0)),  # kitchen table
    *(Post(x, y, 0.02) for x in (8.2, 8.6) for y in (3.2, 3.6)),  # chairs
    *(Post(x, y, 0.02) for x in (8.8, 9.2) for y in (1.6, 2.0)),
    Post(5.6, 4.6, 0.15),  # plant, lamp, bin
    Post(3.6, 6.8, 0.02),
    Post(10.7, 4.6, 0.14),
    Post(0.3, 6.2, 0.12),
    Post(3.0, 3.9, 0.25, softness=12.0),  # pouf
)
_WAYPOINTS = (
    (1.0, 5.7),
    (4.9, 5.7),
    (4.9, 4.3),
    (4.2, 3.2),
    (3.2, 3.2),
    (3.3, 1.2),
    (3.7, 2.4),
    (5.2, 3.1),
    (7.0, 3.1),
    (7.2, 1.3),
    (7.2, 4.3),
    (9.7, 4.3),
    (9.7, 5.8),
    (8.7, 5.8),
    (8.7, 7.2),
    (8.4, 8.6),
    (8.9, 7.3),
    (8.7, 5.75),
    (5.5, 5.75),
    (5.5, 7.9),
    (5.5, 5.8),
    (3.1, 5.8),
    (3.1, 7.4),
    (2.8, 9.0),
    (3.0, 7.3),
    (3.1, 5.7),
    (6.5, 5.7),
    (9.7, 5.7),
    (9.7, 4.2),
    (9.9, 2.0),
    (9.7, 4.3),
    (9.7, 5.75),
    (6.0, 5.8),
)


def home() -> Venue:
    """Much that is soft or thin, and little that is large and smooth."""
    world = Furnishing(boxes=_BOXES, posts=_POSTS).world("home", _PLAN, 22.0)
    return Venue(world, Tour(_WAYPOINTS, frozenset({3, 8, 15, 23, 29})))
