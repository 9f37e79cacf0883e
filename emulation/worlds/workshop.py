"""A workshop of 13 x 9 m, and its store: benches, machines of rough cast iron, bar stock, gas bottles."""

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.motion import Tour
from echogrid.emulation.worlds.furnishing import Box, Furnishing, Post
from echogrid.emulation.worlds.venue import Venue

_PLAN = FloorPlan(
    floors=(
        (0.0, 0.0, 13.0, 9.0),  # hall
        (13.1, 5.4, 16.0, 9.0),  # store
        (13.0, 6.6, 13.1, 7.8),  # its doorway
        (4.0, -0.25, 7.0, 0.0),  # roller door, set back
    ),
    furniture=(
        (0.0, 1.4, 0.8, 5.0),  # bench along the west wall
        (0.0, 8.2, 2.6, 9.0),  # cupboards
        (5.0, 8.3, 8.2, 9.0),  # bench along the north wall
        (4.2, 3.6, 6.4, 4.8),  # lathe
        (8.6, 3.2, 9.8, 4.6),  # mill
        (11.9, 1.6, 13.0, 3.4),  # press
        (9.6, 0.0, 11.0, 0.4),  # bar stock
        (15.4, 5.4, 16.0, 8.0),  # store: shelves
        (13.1, 8.5, 14.6, 9.0),
    ),
    rough=(
        (4.2, 3.6, 6.4, 3.6),  # castings
        (4.2, 3.6, 4.2, 4.8),
        (8.6, 3.2, 8.6, 4.6),
        (8.6, 4.6, 9.8, 4.6),
        (11.9, 1.6, 11.9, 3.4),
        (9.6, 0.4, 11.0, 0.4),  # ends of bars
        (0.0, 5.0, 0.0, 8.2),  # brick
        (15.4, 5.4, 15.4, 8.0),  # goods on shelves
    ),
)
_BOXES = (
    Box(2.9, 5.9, 1.3, 0.8, 30.0),  # welding table
    Box(7.3, 6.4, 0.7, 0.5, -25.0),  # tool trolley
    Box(11.2, 5.6, 1.0, 0.8, 55.0, rough=True),  # pallet of castings
    Box(2.2, 0.7, 0.8, 0.6, 12.0),  # bin
    Box(12.3, 8.3, 0.6, 0.6, 45.0),
)
_POSTS = (
    Post(7.4, 1.0, 0.12),  # pillar drill
    Post(6.9, 3.0, 0.11),  # hoist
    Post(9.2, 8.6, 0.115),  # gas bottles
    Post(9.6, 8.7, 0.115),
    Post(10.0, 8.6, 0.115),
    Post(3.6, 8.4, 0.29),  # drum
    Post(1.05, 3.1, 0.18, softness=10.0),  # stool
    Post(12.6, 0.5, 0.2),
    Post(14.0, 5.8, 0.05),
)
_SCREENS = ((3.6, 7.2, 4.9, 6.7), (10.4, 8.2, 10.7, 7.5))
"""Welding curtains of stiff plastic."""
_WAYPOINTS = (
    (1.7, 4.4),
    (1.6, 1.9),
    (3.4, 1.5),
    (6.0, 1.9),
    (8.2, 1.4),
    (8.2, 2.7),
    (9.2, 1.4),
    (10.9, 1.1),
    (10.8, 4.5),
    (12.2, 4.6),
    (12.2, 7.2),
    (14.6, 7.2),
    (14.5, 6.1),
    (14.7, 7.5),
    (12.1, 7.0),
    (9.8, 6.9),
    (8.6, 5.6),
    (8.3, 7.4),
    (6.0, 7.6),
    (6.0, 5.8),
    (7.5, 5.2),
    (7.6, 2.2),
    (3.4, 2.4),
    (3.3, 4.7),
    (1.9, 4.8),
    (1.4, 5.8),
    (1.4, 7.5),
    (2.9, 7.4),
    (1.3, 7.1),
    (1.5, 5.4),
)


def workshop() -> Venue:
    """Rough and smooth side by side. Nothing was tuned on it."""
    furnishing = Furnishing(screens=_SCREENS, boxes=_BOXES, posts=_POSTS)
    return Venue(furnishing.world("workshop", _PLAN, 16.0), Tour(_WAYPOINTS, frozenset({2, 5, 12, 19, 27})))
