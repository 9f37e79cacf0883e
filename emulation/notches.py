"""Where walls meet: concave corners, convex edges and free ends, found from the geometry."""

from dataclasses import dataclass
from itertools import pairwise
from math import atan2, cos, pi, radians, sin

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

JOINT = 1e-6
"""m: ends nearer than this are one joint."""
_SHARPEST_BEND = radians(45.0)
"""Two walls that differ less in direction only bend: neither a corner nor an edge."""


@dataclass(frozen=True, eq=False, slots=True)
class Notches:
    """The open angles between neighbouring walls at their joints; a joint has one for each side.

    A concave corner is an angle of at most 135 deg: sound that comes from within it returns the way it
    came. A convex edge is one of at least 225 deg, a free end one of 360 deg: they diffract.
    """

    points: FloatArray
    """(k, 2) m: the joint."""
    middle: FloatArray
    """(k, 2): unit vector from the joint along the bisector of the open angle."""
    cosine: FloatArray
    """(k,): cosine of half of the open angle; whoever sees the joint under less than this is outside."""
    corner: NDArray[np.bool_]
    """(k,): concave corner, otherwise edge or free end."""

    def only(self, chosen: NDArray[np.bool_]) -> "Notches":
        """Those for which `chosen` (k,) holds."""
        return Notches(self.points[chosen], self.middle[chosen], self.cosine[chosen], self.corner[chosen])


def find_notches(walls: FloatArray, rough: NDArray[np.bool_]) -> Notches:
    """The notches of walls (n, 4) x0, y0, x1, y1 m. Walls may meet at ends or end on one another.

    Corners of which a side is rough are left out: they scatter.
    """
    rows: list[tuple[float, ...]] = []
    for joint in _joints(walls):
        directions, scatters = _directions_from(joint, walls, rough)
        for start, end in pairwise([*directions, directions[0] + 2.0 * pi]):
            gap = end - start
            bent = abs(gap - pi) >= _SHARPEST_BEND - 1e-9
            if bent and not (gap < pi and scatters):
                middle = start + 0.5 * gap
                rows.append((*joint, cos(middle), sin(middle), cos(0.5 * gap), gap < pi))
    table = np.array(rows, dtype=np.float64).reshape(-1, 6)
    return Notches(table[:, 0:2], table[:, 2:4], table[:, 4], table[:, 5] > 0.5)


def _joints(walls: FloatArray) -> list[FloatArray]:
    """The ends of walls, each place once."""
    joints: list[FloatArray] = []
    for end in walls.reshape(-1, 2):
        if all(abs(end - other).max() > JOINT for other in joints):
            joints.append(end)
    return joints


def _directions_from(
    joint: FloatArray, walls: FloatArray, rough: NDArray[np.bool_]
) -> tuple[list[float], bool]:
    """Headings, rad, ascending, in which walls leave a joint, and whether one of these walls is rough."""
    to_ends = walls.reshape(-1, 2, 2) - joint
    reach = np.hypot(to_ends[..., 0], to_ends[..., 1])
    length = np.hypot(*(to_ends[:, 1] - to_ends[:, 0]).T)
    touching = reach.sum(axis=1) < length + JOINT
    leaving = to_ends[touching][reach[touching] > 2.0 * JOINT]
    headings = sorted(atan2(dy, dx) for dx, dy in leaving)
    distinct = [a for a, b in pairwise([*headings, headings[0] + 2.0 * pi]) if b - a > 1e-6]
    return distinct, bool(rough[touching].any())
