"""Four rooms of 12 x 8 m in a row, behind one another through doors of 0.9, 0.8 and 0.7 m."""

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.worlds.arena import Arena
from echogrid.emulation.worlds.furnishing import Furnishing, Post

_PLAN = FloorPlan(
    floors=(
        (0.0, 0.0, 2.9, 8.0),
        (3.0, 0.0, 5.9, 8.0),
        (6.0, 0.0, 8.9, 8.0),
        (9.0, 0.0, 12.0, 8.0),
        (2.9, 1.2, 3.0, 2.1),  # doorways from here on
        (5.9, 5.6, 6.0, 6.4),
        (8.9, 2.6, 9.0, 3.3),
    ),
    furniture=((0.0, 7.2, 1.6, 8.0), (3.0, 3.4, 3.6, 4.8), (7.2, 0.0, 8.4, 0.5), (11.2, 5.0, 12.0, 6.6)),
    rough=((0.0, 0.0, 0.0, 3.0),),
)
_POSTS = (Post(4.6, 2.6, 0.1), Post(7.5, 5.4, 0.12))


def narrow_doors() -> Arena:
    """Each door is found only by whoever comes near it, and little wider than the robot."""
    world = Furnishing(posts=_POSTS).world("narrow-doors", _PLAN)
    return Arena(world, (1.4, 2.0), ((0.6, 1.0, 2.2, 6.2),), ((9.8, 1.0, 11.2, 7.0),))
