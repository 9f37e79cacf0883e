"""A wide passage of 14 x 6 m that seven people cross or walk along, at 0.8 m/s."""

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.walker import Walker
from echogrid.emulation.worlds.arena import Arena
from echogrid.emulation.worlds.furnishing import Furnishing, Post

_PLAN = FloorPlan(
    floors=((0.0, 0.0, 14.0, 6.0),),
    furniture=((3.4, 5.5, 5.0, 6.0), (8.8, 0.0, 10.2, 0.5)),
    rough=((0.0, 0.0, 0.0, 6.0), (14.0, 0.0, 14.0, 6.0)),
)
_POSTS = (Post(4.4, 1.2, 0.15), Post(9.4, 4.6, 0.15))
_WALKERS = (
    Walker(((3.4, 0.6), (3.4, 5.0)), 0.0, radius=0.22, softness=12.0),
    Walker(((5.6, 5.4), (5.9, 0.6)), 3.0, radius=0.2, softness=10.0),
    Walker(((7.4, 0.6), (7.2, 5.4), (7.8, 5.4), (8.0, 0.6)), 5.0, radius=0.25, softness=15.0),
    Walker(((10.8, 5.4), (10.6, 0.7)), 1.5, radius=0.23, softness=13.0),
    Walker(((12.0, 0.6), (12.2, 5.4)), 7.0, radius=0.21, softness=11.0),
    Walker(((2.4, 2.4), (13.0, 2.2), (13.0, 2.9), (2.4, 3.0)), 9.0, radius=0.22, softness=12.0),
    Walker(((13.2, 4.0), (2.6, 3.8), (2.6, 3.4), (13.2, 3.4)), 4.0, radius=0.24, softness=14.0),
)


def passers_by() -> Arena:
    """They do not look where they go, and do not give way."""
    world = Furnishing(posts=_POSTS, walkers=_WALKERS).world("passers-by", _PLAN)
    return Arena(world, (1.2, 3.0), ((0.6, 0.8, 1.6, 5.2),), ((12.8, 0.8, 13.4, 5.2),))
