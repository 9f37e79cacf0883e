"""A ring of smooth corridors, 22 x 14 m, with recessed doors, two blind branches and little else."""

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.motion import Tour
from echogrid.emulation.worlds.furnishing import Furnishing, Post
from echogrid.emulation.worlds.venue import Venue

_PLAN = FloorPlan(
    floors=(
        (0.0, 0.0, 22.0, 1.9),  # south
        (0.0, 12.0, 22.0, 14.0),  # north
        (0.0, 0.0, 2.0, 14.0),  # west
        (20.2, 0.0, 22.0, 14.0),  # east
        (9.8, 1.9, 11.4, 7.0),  # branch from the south
        (15.0, 9.5, 16.8, 12.0),  # branch from the north
        (3.2, 1.9, 4.1, 2.0),  # doors, recessed by 10 cm, from here on
        (6.4, 1.9, 7.3, 2.0),
        (13.0, 1.9, 13.9, 2.0),
        (17.4, 1.9, 18.3, 2.0),
        (5.0, -0.1, 5.9, 0.0),
        (12.0, -0.1, 12.9, 0.0),
        (16.2, -0.1, 18.0, 0.0),
        (4.0, 11.9, 4.9, 12.0),
        (8.2, 11.9, 9.1, 12.0),
        (12.2, 11.9, 13.1, 12.0),
        (6.0, 14.0, 6.9, 14.1),
        (10.4, 14.0, 11.3, 14.1),
        (17.0, 14.0, 18.8, 14.1),
        (2.0, 4.2, 2.1, 5.1),
        (2.0, 8.6, 2.1, 9.5),
        (-0.1, 6.2, 0.0, 7.1),
        (20.1, 3.8, 20.2, 4.7),
        (20.1, 8.0, 20.2, 8.9),
        (22.0, 5.6, 22.1, 6.5),
    ),
    furniture=(
        (8.0, 0.0, 9.0, 0.12),  # radiators
        (14.0, 13.88, 15.0, 14.0),
        (21.7, 10.0, 22.0, 10.8),  # fire hose
        (0.0, 3.0, 0.35, 3.9),  # bench
        (15.0, 9.5, 15.5, 10.2),  # cupboard
    ),
    rough=((0.0, 12.0, 0.0, 14.0), (20.2, 0.0, 22.0, 0.0)),  # bricks
)
_POSTS = (Post(21.6, 13.4, 0.15), Post(0.4, 0.4, 0.18), Post(11.1, 6.7, 0.12), Post(19.8, 12.3, 0.05))
_WAYPOINTS = (
    (1.0, 1.0),
    (10.6, 0.95),
    (10.6, 5.8),
    (10.4, 1.05),
    (21.0, 0.9),
    (21.1, 6.0),
    (21.0, 12.9),
    (15.9, 13.0),
    (15.95, 10.8),
    (15.6, 13.0),
    (7.0, 13.1),
    (1.1, 12.9),
    (0.95, 7.0),
)


def corridor() -> Venue:
    """Smooth walls almost everywhere: most of them are met at a slant."""
    world = Furnishing(posts=_POSTS).world("corridor", _PLAN)
    return Venue(world, Tour(_WAYPOINTS, frozenset({2, 5, 8, 11})))
