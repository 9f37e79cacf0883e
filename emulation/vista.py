"""What can be seen at all from a small part of the floor, in plain numbers: a ping looks at nothing else.

Loops over the few things in sight are quicker here than arrays of everything.
"""

from collections.abc import Sequence
from itertools import compress
from math import inf, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
Point = tuple[float, float]

TOUCH = 1e-6
"""m: a sight line which comes this near to a surface ends on it and does not cross it."""
NO_WALL = -1
_PARALLEL = 1e-12
_SURE = 2.0 * TOUCH
_LEAST_SHADE = 0.5
"""m: walls shorter than this hide little, and are not asked whether they do."""
_QUARTER_TURN = np.array(((0.0, 1.0), (-1.0, 0.0)))


class Wall(NamedTuple):
    """A wall as a line and a stretch of it; map frame, m."""

    number: int
    normal_x: float
    normal_y: float
    offset: float
    """Of the line from the origin, along the normal."""
    along_x: float
    along_y: float
    first_reached: float
    """Where it begins, along itself, from the foot of the origin."""
    length: float
    softness: float
    """dB: what it takes from the sound that it returns."""

    @property
    def ends(self) -> tuple[Point, Point]:
        """Both of its ends."""
        _, normal_x, normal_y, offset, along_x, along_y, first, length, _ = self
        x, y = offset * normal_x + first * along_x, offset * normal_y + first * along_y
        return (x, y), (x + length * along_x, y + length * along_y)


class Barrier(NamedTuple):
    """A wall as what a sight line may cross."""

    normal_x: float
    normal_y: float
    offset: float
    start_x: float
    start_y: float
    span_x: float
    span_y: float


class Notch(NamedTuple):
    """A corner, an edge or a free end, and the cone in which it is heard."""

    x: float
    y: float
    middle_x: float
    middle_y: float
    cosine: float
    softness: float
    """dB."""


class Post(NamedTuple):
    """A cylinder."""

    x: float
    y: float
    radius: float
    softness: float
    """dB."""

    @property
    def square(self) -> tuple[Point, ...]:
        """The corners of the square around it."""
        x, y, radius, _ = self
        west, east, south, north = x - radius, x + radius, y - radius, y + radius
        return (west, south), (east, south), (east, north), (west, north)


class Vista(NamedTuple):
    """All that may be seen from somewhere in a convex part of the floor; nothing else can be."""

    walls: tuple[Wall, ...]
    barriers: tuple[Barrier, ...]
    """The walls once more."""
    smooth: tuple[Wall, ...]
    """Those walls which mirror sound, if they are met at a right angle from somewhere there."""
    rough: tuple[Wall, ...]
    """Those walls which scatter it."""
    corners: tuple[Notch, ...]
    """Concave ones."""
    edges: tuple[Notch, ...]
    """Convex ones, and free ends."""
    posts: tuple[Post, ...]

    def seen_from(self, viewers: FloatArray) -> "Vista":
        """What of this may be seen from somewhere between the viewers (v, 2), m."""
        part = _Part.around(viewers, self.barriers)
        seen = part.sees([wall.ends for wall in self.walls])
        walls = tuple(compress(self.walls, seen))
        numbers = {wall.number for wall in walls}
        smooth = [wall for wall in self.smooth if wall.number in numbers]
        return Vista(
            walls,
            tuple(compress(self.barriers, seen)),
            tuple(compress(smooth, part.beside(smooth))),
            tuple(wall for wall in self.rough if wall.number in numbers),
            part.faced(self.corners),
            part.faced(self.edges),
            tuple(compress(self.posts, part.sees([post.square for post in self.posts]))),
        )

    def clear(self, here: Point, there: Point) -> bool:
        """Whether nothing stands between a place in the part and a target.

        A surface on which either lies does not count.
        """
        (x, y), (to_x, to_y) = here, there
        way_x, way_y = to_x - x, to_y - y
        for normal_x, normal_y, offset, start_x, start_y, span_x, span_y in self.barriers:
            near = normal_x * x + normal_y * y - offset
            far = normal_x * to_x + normal_y * to_y - offset
            if near * far < 0.0 and abs(near) > TOUCH and abs(far) > TOUCH:
                first = way_x * (start_y - y) - way_y * (start_x - x)
                if first * (first + way_x * span_y - way_y * span_x) <= 0.0:
                    return False
        return not self.posts or not self._crossed(x, y, way_x, way_y)

    def _crossed(self, x: float, y: float, way_x: float, way_y: float) -> bool:
        """Whether a sight line passes through a cylinder."""
        square = max(way_x * way_x + way_y * way_y, TOUCH * TOUCH)
        for post_x, post_y, radius, _ in self.posts:
            to_x, to_y = post_x - x, post_y - y
            share = min(max((to_x * way_x + to_y * way_y) / square, 0.0), 1.0)
            miss_x, miss_y = to_x - share * way_x, to_y - share * way_y
            if sqrt(miss_x * miss_x + miss_y * miss_y) < radius - TOUCH:
                return True
        return False

    def cast(self, origin: Point, ray: Point) -> tuple[float, int]:
        """Distance, m, of the first surface along a ray (unit vector) from the part, and the wall it is.

        inf where there is none; NO_WALL for cylinders and nothing.
        """
        (x, y), (ray_x, ray_y) = origin, ray
        nearest, struck = inf, NO_WALL
        for number, normal_x, normal_y, offset, along_x, along_y, first, length, _ in self.walls:
            approach = normal_x * ray_x + normal_y * ray_y
            if abs(approach) < _PARALLEL:
                approach = _PARALLEL
            distance = (offset - normal_x * x - normal_y * y) / approach
            if TOUCH < distance < nearest:
                reached = along_x * x + along_y * y - first + distance * (along_x * ray_x + along_y * ray_y)
                if -TOUCH <= reached <= length + TOUCH:
                    nearest, struck = distance, number
        on_post = self._met(x, y, ray_x, ray_y) if self.posts else inf
        return (on_post, NO_WALL) if on_post <= nearest else (nearest, struck)

    def _met(self, x: float, y: float, ray_x: float, ray_y: float) -> float:
        """Distance, m, at which a ray enters the first cylinder; inf where there is none."""
        nearest = inf
        for post_x, post_y, radius, _ in self.posts:
            to_x, to_y = post_x - x, post_y - y
            middle = to_x * ray_x + to_y * ray_y
            if middle > TOUCH:
                inside = middle * middle - (to_x * to_x + to_y * to_y) + radius * radius
                if inside >= 0.0 and TOUCH < (distance := middle - sqrt(inside)) < nearest:
                    nearest = distance
        return nearest


class _Part(NamedTuple):
    """A convex part of the floor, the circle around it, and the walls which may hide something from it."""

    vertices: FloatArray
    """(v, 2) m."""
    centre: FloatArray
    radius: float
    starts: FloatArray
    """(n, 2) m."""
    spans: FloatArray
    """(n, 2) m."""

    @classmethod
    def around(cls, vertices: FloatArray, barriers: Sequence[Barrier]) -> "_Part":
        """The part with these vertices. Short walls are left out: they hide little."""
        centre = vertices.mean(axis=0)
        radius = float(np.hypot(*(vertices - centre).T).max())
        walls = np.array([barrier[3:] for barrier in barriers]).reshape(-1, 4)
        walls = walls[np.hypot(walls[:, 2], walls[:, 3]) > _LEAST_SHADE]
        return cls(vertices, centre, radius, walls[:, :2], walls[:, 2:])

    def faced(self, notches: Sequence[Notch]) -> tuple[Notch, ...]:
        """The notches which may be seen, from within their cones."""
        table = np.array(notches).reshape(-1, 6)
        offset = self.centre - table[:, :2]
        distance = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), TOUCH)
        bearing = np.arccos(np.clip(np.vecdot(offset, table[:, 2:4]) / distance, -1.0, 1.0))
        slack = np.where(distance > self.radius, np.arcsin(np.minimum(self.radius / distance, 1.0)), pi)
        facing = tuple(compress(notches, bearing <= np.arccos(table[:, 4]) + slack + TOUCH))
        return tuple(compress(facing, self.sees([(notch[:2],) for notch in facing])))

    def beside(self, walls: Sequence[Wall]) -> BoolArray:
        """Which walls (k) are met at a right angle from somewhere in the circle, as (k,)."""
        table = np.array(walls).reshape(-1, 9)
        middle = 0.5 * table[:, 7]
        from_middle = table[:, 4:6] @ self.centre - table[:, 6] - middle
        return np.asarray(np.abs(from_middle) <= middle + self.radius + TOUCH)

    def sees(self, targets: Sequence[Sequence[Point]]) -> BoolArray:
        """Which convex targets (k, of c vertices each) may be seen from somewhere in the part, as (k,).

        Where all sight lines from vertex to vertex cross one and the same wall, so do all those between: a
        wall's shadow is convex. What only several walls hide together is taken to be seen.
        """
        if not targets:
            return np.empty(0, dtype=np.bool_)
        vertices = len(targets[0])
        shadows = self._shadows(np.array(targets).reshape(-1, 2)).reshape(len(targets), vertices, -1)
        hidden: BoolArray = np.logical_and.reduce(shadows, axis=1)
        return np.asarray(~np.logical_or.reduce(hidden, axis=1))

    def _shadows(self, points: FloatArray) -> BoolArray:
        """(k, n): which points (k, 2) lie wholly, for all of the part, in the shadow of which wall."""
        normals = self.spans @ _QUARTER_TURN / np.hypot(self.spans[:, 0], self.spans[:, 1])[:, np.newaxis]
        offsets = np.vecdot(self.starts, normals)
        here, there = self.vertices @ normals.T - offsets, points @ normals.T - offsets
        dark = (here.max(axis=0) < -_SURE) & (there > _SURE) | (here.min(axis=0) > _SURE) & (there < -_SURE)
        for viewer in self.vertices:
            sideways = (points - viewer) @ _QUARTER_TURN
            first = sideways @ (self.starts - viewer).T
            dark &= first * (first + sideways @ self.spans.T) < 0.0
        return np.asarray(dark)
