"""Corridors of 13 x 9 m, 1.3 to 1.6 m wide: most of their branches lead nowhere."""

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.worlds.arena import Arena
from echogrid.emulation.worlds.furnishing import Furnishing, Post

_PLAN = FloorPlan(
    floors=(
        (0.0, 3.8, 13.0, 5.2),  # main corridor
        (2.4, 5.2, 3.8, 8.6),  # dead ends, to the north
        (5.6, 5.2, 6.9, 7.4),
        (4.0, 0.6, 5.4, 3.8),  # and to the south
        (7.6, 1.8, 8.9, 3.8),
        (9.2, 5.2, 10.6, 9.0),  # the way to the upper corridor
        (4.4, 7.8, 10.6, 9.0),
        (11.4, 0.0, 13.0, 3.8),  # and to the lower one
        (6.6, 0.0, 13.0, 1.4),
    ),
    furniture=((13.0 - 0.4, 4.8, 13.0, 5.2), (0.0, 3.8, 0.3, 4.2)),
    rough=((2.4, 8.6, 3.8, 8.6), (0.0, 3.8, 0.0, 5.2)),
)
_POSTS = (Post(11.8, 5.0, 0.08),)


def dead_ends() -> Arena:
    """The goal lies behind a wall of the branches."""
    world = Furnishing(posts=_POSTS).world("dead-ends", _PLAN)
    goals = ((4.8, 8.1, 6.6, 8.6), (7.2, 0.4, 8.6, 1.0))
    return Arena(world, (1.2, 4.5), ((0.8, 4.3, 1.8, 4.8),), goals)
