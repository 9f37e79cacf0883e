"""A cool warehouse of 24 x 14 m: three rows of racks with pallets, some places empty, between steel walls."""

from collections.abc import Iterator

from echogrid.emulation.floor_plan import FloorPlan, Rectangle
from echogrid.emulation.motion import Tour
from echogrid.emulation.worlds.furnishing import Box, Furnishing, Post
from echogrid.emulation.worlds.venue import Venue

_PITCH = 1.4
"""m, from pallet to pallet."""
_FIRST_X = 4.0
_ROWS = (
    # South front, and for each place by how far, cm, the pallet stands behind it; None: empty.
    (2.6, (0, 8, 3, None, 5, 0, 12, 2, None, 6, 4, 0)),
    (6.4, (5, 0, None, 10, 2, 7, 0, None, None, 3, 9, 1)),
    (10.2, (0, 4, 6, 1, None, 11, 3, 0, 5, 8, None, 2)),
)


def _pallets() -> Iterator[Rectangle]:
    for front, places in _ROWS:
        for index, behind in enumerate(places):
            if behind is not None:
                x, y = _FIRST_X + index * _PITCH, front + behind / 100.0
                yield (x, y, x + 1.2, y + 0.8)


def _uprights() -> Iterator[Post]:
    for front, places in _ROWS:
        for index in range(0, len(places) + 1, 2):
            x = _FIRST_X - 0.1 + index * _PITCH
            yield Post(x, front, 0.06)
            yield Post(x, front + 1.1, 0.06)


_PLAN = FloorPlan(
    floors=((0.0, 0.0, 24.0, 14.0), (24.0, 5.5, 24.4, 8.5)),  # hall, gate
    furniture=(*_pallets(), (9.0, 13.2, 12.0, 14.0), (0.0, 6.2, 0.6, 7.8)),
    rough=((0.0, 0.0, 24.0, 0.0), (0.0, 8.0, 0.0, 14.0), (24.0, 0.0, 24.0, 5.5)),  # corrugated steel
)
_BOXES = (Box(22.8, 13.2, 1.0, 0.8, 20.0), Box(0.9, 0.7, 1.2, 0.8, 5.0), Box(17.4, 13.4, 1.2, 0.8, -8.0))
_WAYPOINTS = (
    (2.2, 1.3),
    (12.0, 1.2),
    (22.2, 1.4),
    (22.2, 5.0),
    (13.0, 5.1),
    (2.2, 4.9),
    (2.2, 8.8),
    (11.0, 8.9),
    (22.2, 8.8),
    (22.0, 11.9),
    (12.8, 12.2),
    (2.2, 12.7),
    (2.4, 7.0),
)


def warehouse() -> Venue:
    """Long fronts, broken by gaps that are a little narrower than most beams."""
    world = Furnishing(boxes=_BOXES, posts=tuple(_uprights())).world("warehouse", _PLAN, 12.0)
    return Venue(world, Tour(_WAYPOINTS, frozenset({2, 5, 8, 11})))
