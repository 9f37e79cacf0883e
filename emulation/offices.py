"""An office floor of 14 x 10 m to drive through, and a round through it."""

import numpy as np

from echogrid.emulation.circuit import Circuit
from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.motion import Tour
from echogrid.emulation.world import World

_PLAN = FloorPlan(
    floors=(
        (0.0, 4.2, 14.0, 5.9),  # corridor
        (0.0, 0.0, 4.6, 4.1),  # study
        (4.7, 0.0, 9.3, 4.1),  # workshop
        (9.4, 0.0, 14.0, 4.1),  # store
        (0.0, 6.0, 5.9, 10.0),  # kitchen
        (6.0, 6.0, 14.0, 10.0),  # open-plan office
        (2.0, 4.1, 3.0, 4.2),  # doorways from here on
        (6.4, 4.1, 7.4, 4.2),
        (11.0, 4.1, 12.0, 4.2),
        (3.4, 5.9, 4.4, 6.0),
        (11.6, 5.9, 12.6, 6.0),
        (4.6, 1.2, 4.7, 2.2),
        (5.9, 7.4, 6.0, 8.4),
        (5.2, 4.15, 5.8, 4.2),  # niche of a radiator in the corridor
    ),
    furniture=(
        (0.0, 2.8, 0.45, 4.1),  # study: cabinet, desk
        (0.0, 0.0, 1.6, 0.8),
        (5.2, 3.5, 6.1, 4.1),  # workshop: cabinet, bench, island
        (8.5, 0.6, 9.3, 2.6),
        (6.6, 0.0, 7.6, 0.5),
        (9.4, 0.0, 9.9, 2.4),  # store: shelves
        (11.4, 1.7, 12.0, 2.3),
        (13.4, 2.6, 14.0, 4.1),
        (0.0, 9.4, 3.0, 10.0),  # kitchen: counter, table
        (1.6, 7.2, 2.6, 7.9),
        (8.2, 7.3, 9.8, 8.1),  # office: desks, cabinets
        (12.8, 7.6, 13.4, 9.0),
        (6.0, 9.55, 7.2, 10.0),
        (13.6, 4.2, 14.0, 4.6),  # corridor: copier
    ),
    rough=(
        (14.0, 6.0, 14.0, 10.0),  # brick gable
        (8.2, 7.3, 9.8, 7.3),  # cloth front of a desk
        (4.7, 0.0, 6.6, 0.0),  # brick pier
        (0.0, 6.0, 0.0, 8.4),  # curtain
    ),
)
_SCREENS = ((10.4, 9.6, 11.2, 9.2), (3.3, 0.5, 4.0, 0.9))
"""Slanted room dividers, smooth, free on both ends."""
_POSTS = (
    (10.9, 8.3, 0.15),
    (7.2, 8.9, 0.15),
    (13.2, 1.3, 0.2),
    (0.9, 8.6, 0.06),
    (3.6, 3.3, 0.03),
    (8.0, 3.2, 0.05),
)
_WAYPOINTS = (
    (0.8, 5.05),
    (2.5, 5.05),
    (2.5, 1.7),
    (6.0, 1.7),
    (6.9, 2.4),
    (6.9, 5.05),
    (11.5, 5.05),
    (11.5, 3.0),
    (10.6, 2.6),
    (10.6, 0.8),
    (12.4, 0.8),
    (12.8, 2.2),
    (11.5, 3.4),
    (11.5, 5.05),
    (12.1, 5.05),
    (12.1, 9.5),
    (11.8, 6.7),
    (7.5, 6.7),
    (7.5, 7.9),
    (3.9, 7.9),
    (3.3, 8.8),
    (1.6, 8.6),
    (0.8, 7.4),
    (1.2, 6.6),
    (3.9, 6.8),
    (3.9, 5.05),
    (13.0, 5.05),
)
_LOOK_AROUND = frozenset({2, 4, 8, 11, 17, 20, 23})
_CORNERS = (
    (8.0, 5.05),
    (12.1, 5.05),
    (12.1, 6.7),
    (7.5, 6.7),
    (7.5, 7.9),
    (3.9, 7.9),
    (3.9, 5.05),
    (2.5, 5.05),
    (2.5, 1.7),
    (6.9, 1.7),
    (6.9, 5.05),
)
_CORNER_RADIUS = 0.5


def office() -> World:
    """The floor with its furniture: smooth paint mostly, some brick and cloth, a few posts."""
    walls, rough, _ = _PLAN.outline()
    screens = np.array(_SCREENS)
    return World(
        name="office",
        walls=np.concatenate((walls, screens)),
        rough=np.concatenate((rough, np.zeros(len(screens), dtype=np.bool_))),
        cylinders=np.array(_POSTS),
    )


def office_tour(pause: float = 0.0) -> Tour:
    """A round through the corridor and every room for a robot of radius 0.25 m, which stands for so long (s)
    before each line and each turn."""
    return Tour(_WAYPOINTS, _LOOK_AROUND, pause=pause)


def office_circuit() -> Circuit:
    """A round through the corridor and every room with two doors, for a robot that can't turn in place."""
    return Circuit(_CORNERS, _CORNER_RADIUS)
