"""The robot's outline on the floor: any polygon that does not cross itself, convex or not."""

from collections.abc import Sequence
from itertools import combinations
from math import hypot

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Corner = tuple[float, float]

MOST_CORNERS = 64
_ROUND = 0.01
"""m: corners that stick out of a circle by less than that are how a disc is written down."""
_NARROWEST = 1e-3
"""m: a shorter side is none."""


class Footprint:
    """Corners (m, base_link) in their order around the robot, in either direction.

    Raises ValueError for what is no outline.
    """

    def __init__(self, corners: Sequence[Corner]) -> None:
        _require_outline(corners)
        self.corners = tuple((float(x), float(y)) for x, y in corners)
        self.x, self.y = np.array(self.corners, np.float64).T
        """(k,) m."""
        dx, dy = np.roll(self.x, -1) - self.x, np.roll(self.y, -1) - self.y
        self.length: Floats = np.hypot(dx, dy)
        """(k,) m, of the side from each corner to the next."""
        self.along: tuple[Floats, Floats] = dx / self.length, dy / self.length
        """(k,) each: the direction of that side."""
        area = (self.x * np.roll(self.y, -1) - self.y * np.roll(self.x, -1)).sum()
        self.outward = 1.0 if area > 0.0 else -1.0
        """1 if the right of each side is outside, as the corners come counter-clockwise; else -1."""
        self._rise, self._run = np.where(dy == 0.0, 1.0, dy)[:, np.newaxis], dx[:, np.newaxis]
        self.reach = max(hypot(x, y) for x, y in self.corners)
        """m from base_link to the farthest corner."""
        self.is_round = self.reach - self._inner() <= _ROUND
        """Whether it is a disc around base_link: who turns in place then comes nearer to nothing."""

    @classmethod
    def box(cls, rear: float, front: float, half_width: float) -> "Footprint":
        """A rectangle from x = rear to x = front (m)."""
        return cls(((rear, -half_width), (front, -half_width), (front, half_width), (rear, half_width)))

    def distance(self, x: Floats, y: Floats) -> Floats:
        """(n,) m from points (n,) to the outline; 0 within."""
        px, py = x - self.x[:, np.newaxis], y - self.y[:, np.newaxis]
        ex, ey = (each[:, np.newaxis] for each in self.along)
        foot = np.minimum(np.maximum(px * ex + py * ey, 0.0), self.length[:, np.newaxis])
        away = np.hypot(px - foot * ex, py - foot * ey).min(axis=0)
        result: Floats = np.where(self.contains(x, y), 0.0, away)
        return result

    def _inner(self) -> float:
        """m from base_link to the nearest side; 0 from without."""
        if not self.contains(np.zeros(1), np.zeros(1))[0]:
            return 0.0
        ex, ey = self.along
        foot = np.minimum(np.maximum(-self.x * ex - self.y * ey, 0.0), self.length)
        return float(np.hypot(self.x + foot * ex, self.y + foot * ey).min())

    def contains(self, x: Floats, y: Floats) -> NDArray[np.bool_]:
        """(n,) Whether points (n,) lie within: a ray from each crosses the outline an odd number of times."""
        below = self.y[:, np.newaxis] <= y
        crosses = below != np.concatenate((below[1:], below[:1]))
        at = self.x[:, np.newaxis] + (y - self.y[:, np.newaxis]) / self._rise * self._run
        odd: NDArray[np.bool_] = np.logical_xor.reduce(crosses & (at > x), axis=0)
        return odd


def _require_outline(corners: Sequence[Corner]) -> None:
    if not 3 <= len(corners) <= MOST_CORNERS:
        raise ValueError(f"an outline has 3...{MOST_CORNERS} corners, not {len(corners)}")
    sides = [(corner, corners[(k + 1) % len(corners)]) for k, corner in enumerate(corners)]
    if any(hypot(b[0] - a[0], b[1] - a[1]) < _NARROWEST for a, b in sides):
        raise ValueError("two corners that follow each other are one point")
    for (i, one), (j, other) in combinations(enumerate(sides), 2):
        neighbours = j - i in (1, len(sides) - 1)
        if _fold(one, other) if neighbours else _meet(one, other):
            raise ValueError(f"the outline crosses itself: side {i + 1} meets side {j + 1}")


def _turn(a: Corner, b: Corner, c: Corner) -> float:
    """Above 0 if the way from a over b to c turns to the left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _meet(one: tuple[Corner, Corner], other: tuple[Corner, Corner]) -> bool:
    """Whether two sides have a point in common."""
    (a, b), (c, d) = one, other
    turns = _turn(a, b, c), _turn(a, b, d), _turn(c, d, a), _turn(c, d, b)
    if all(turn == 0.0 for turn in turns):
        return all(max(a[k], b[k]) >= min(c[k], d[k]) and max(c[k], d[k]) >= min(a[k], b[k]) for k in (0, 1))
    return turns[0] * turns[1] <= 0.0 and turns[2] * turns[3] <= 0.0


def _fold(one: tuple[Corner, Corner], other: tuple[Corner, Corner]) -> bool:
    """Whether two sides that share a corner run back over each other."""
    shared = next(corner for corner in one if corner in other)
    a, c = (side[1] if side[0] == shared else side[0] for side in (one, other))
    ahead = (a[0] - shared[0]) * (c[0] - shared[0]) + (a[1] - shared[1]) * (c[1] - shared[1])
    return _turn(a, shared, c) == 0.0 and ahead > 0.0
