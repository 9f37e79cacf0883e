"""Where walls meet: concave corners, convex edges and free ends, found from the geometry."""

from dataclasses import dataclass
from itertools import pairwise
from math import cos, pi, radians, sin

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
    softness: FloatArray
    """(k,) dB taken from the sound: by a corner what both sides take, by an edge what the softer does."""


def find_notches(walls: FloatArray, rough: NDArray[np.bool_], softness: FloatArray) -> Notches:
    """The notches of walls (n, 4) x0, y0, x1, y1 m. Walls may meet at ends or end on one another.

    Corners of which a side is rough are left out: they scatter. Softness, (n,), is in dB.
    """
    rows: list[tuple[float, ...]] = []
    for joint in _joints(walls):
        touching = _touching(joint, walls)
        scatters = bool(rough[touching].any())
        sides = _sides(joint, walls[touching], softness[touching])
        around = (sides[0][0] + 2.0 * pi, sides[0][1])
        for (start, first), (end, second) in pairwise([*sides, around]):
            gap = end - start
            bent = abs(gap - pi) >= _SHARPEST_BEND - 1e-9
            if bent and not (gap < pi and scatters):
                middle, corner = start + 0.5 * gap, gap < pi
                taken = first + second if corner else max(first, second)
                rows.append((*joint, cos(middle), sin(middle), cos(0.5 * gap), corner, taken))
    table = np.array(rows, dtype=np.float64).reshape(-1, 7)
    return Notches(table[:, 0:2], table[:, 2:4], table[:, 4], table[:, 5] > 0.5, table[:, 6])


def _joints(walls: FloatArray) -> list[FloatArray]:
    """The ends of walls, each place once."""
    joints: list[FloatArray] = []
    for end in walls.reshape(-1, 2):
        if all(abs(end - other).max() > JOINT for other in joints):
            joints.append(end)
    return joints


def _touching(joint: FloatArray, walls: FloatArray) -> NDArray[np.bool_]:
    """(n,): which walls pass through a joint, or end there."""
    to_ends = walls.reshape(-1, 2, 2) - joint
    reach = np.hypot(to_ends[..., 0], to_ends[..., 1])
    length = np.hypot(*(to_ends[:, 1] - to_ends[:, 0]).T)
    return np.asarray(reach.sum(axis=1) < length + JOINT)


def _sides(joint: FloatArray, walls: FloatArray, softness: FloatArray) -> list[tuple[float, float]]:
    """Headings, rad, ascending and each once, in which walls leave a joint, and their softness, dB."""
    to_ends = walls.reshape(-1, 2, 2) - joint
    leaving = np.hypot(to_ends[..., 0], to_ends[..., 1]) > 2.0 * JOINT
    headings = np.arctan2(to_ends[..., 1], to_ends[..., 0])[leaving]
    sides = sorted(zip(headings.tolist(), np.repeat(softness, 2)[leaving.ravel()].tolist(), strict=True))
    around = (sides[0][0] + 2.0 * pi, 0.0)
    return [side for side, following in pairwise([*sides, around]) if following[0] - side[0] > 1e-6]
