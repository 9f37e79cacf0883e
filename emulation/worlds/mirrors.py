"""A hall of 12 x 8 m with glass walls at all slants: met at an angle they are silent, or deceive."""

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.worlds.arena import Arena
from echogrid.emulation.worlds.furnishing import Box, Furnishing

_PLAN = FloorPlan(floors=((0.0, 0.0, 12.0, 8.0), (12.0, 3.2, 12.4, 4.8)), furniture=())
_SCREENS = (
    (2.6, 1.2, 4.6, 3.4),
    (2.8, 7.0, 4.4, 4.9),
    (5.6, 3.2, 7.0, 4.6),
    (6.2, 0.0, 7.4, 1.8),
    (6.4, 8.0, 7.2, 6.4),
    (8.4, 5.8, 9.8, 4.0),
    (9.0, 1.2, 9.8, 2.8),
)
_BOXES = (Box(8.4, 3.0, 0.6, 0.6, 28.0), Box(10.4, 6.6, 0.8, 0.8, 45.0))


def mirrors() -> Arena:
    """Nothing scatters: a wall answers only whoever looks at it squarely, and by its ends."""
    world = Furnishing(screens=_SCREENS, boxes=_BOXES).world("mirrors", _PLAN, 18.0)
    return Arena(world, (1.2, 4.0), ((0.6, 1.0, 1.8, 7.0),), ((10.4, 1.0, 11.4, 5.4),))
