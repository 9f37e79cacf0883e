"""What stands around the robot: walls, posts and the air, in one plane."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.notches import Notches, find_notches

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

TOUCH = 1e-6
"""m: a sight line which comes this near to a surface ends on it and does not cross it."""
NO_WALL = -1
_QUARTER_TURN = np.array(((0.0, 1.0), (-1.0, 0.0)))
_PARALLEL = 1e-12


@dataclass(frozen=True, eq=False)
class World:
    """Everything that reflects sound; map frame, m. Walls are thin and have two faces."""

    name: str
    walls: FloatArray
    """(n, 4) float64: x0, y0, x1, y1. They meet at their ends or end on one another, and do not cross."""
    rough: BoolArray
    """(n,): scatters (brick, cloth) rather than mirrors (paint, glass)."""
    cylinders: FloatArray
    """(m, 3) float64: x, y, radius; smooth."""
    temperature: float = 20.0
    """degC."""

    @cached_property
    def starts(self) -> FloatArray:
        """(n, 2): first end of each wall."""
        return np.ascontiguousarray(self.walls[:, :2])

    @cached_property
    def spans(self) -> FloatArray:
        """(n, 2): from the first end of each wall to its second."""
        return np.asarray(self.walls[:, 2:] - self.walls[:, :2], dtype=np.float64)

    @cached_property
    def lengths(self) -> FloatArray:
        """(n,) m."""
        return np.asarray(np.hypot(self.spans[:, 0], self.spans[:, 1]))

    @cached_property
    def along(self) -> FloatArray:
        """(n, 2): unit vector from the first end of each wall to its second."""
        return np.asarray(self.spans / self.lengths[:, np.newaxis], dtype=np.float64)

    @cached_property
    def normals(self) -> FloatArray:
        """(n, 2): unit vector to the left of each wall."""
        return np.asarray(self.along @ _QUARTER_TURN, dtype=np.float64)

    @cached_property
    def offsets(self) -> FloatArray:
        """(n,) m: signed distance of each wall's line from the origin, along its normal."""
        return np.asarray((self.starts * self.normals).sum(axis=1))

    @cached_property
    def first_reached(self) -> FloatArray:
        """(n,) m: how far along each wall, measured from the foot of the origin, it begins."""
        return np.asarray((self.starts * self.along).sum(axis=1))

    @cached_property
    def scattering(self) -> IntArray:
        """Indices of the rough walls."""
        return np.flatnonzero(self.rough)

    @cached_property
    def notches(self) -> Notches:
        """The corners, edges and free ends."""
        return find_notches(self.walls, self.rough)

    @cached_property
    def corners(self) -> Notches:
        """The concave corners alone."""
        return self.notches.only(self.notches.corner)

    def line_of_sight(self, origins: FloatArray, targets: FloatArray) -> BoolArray:
        """Whether nothing stands between origins (k, 2) or (1, 2) and targets (k, 2), as (k,).

        A surface on which either lies does not count.
        """
        crossed = self._crossed_walls(origins, targets).any(axis=1)
        if len(self.cylinders):
            crossed |= self._crossed_cylinders(origins, targets).any(axis=1)
        return np.asarray(~crossed)

    def _crossed_walls(self, origins: FloatArray, targets: FloatArray) -> BoolArray:
        """(k, n): both ends of the sight line on two sides of the wall, and the reverse."""
        here = origins @ self.normals.T - self.offsets
        there = targets @ self.normals.T - self.offsets
        crosses = (np.minimum(here, there) < -TOUCH) & (np.maximum(here, there) > TOUCH)
        sideways = (targets - origins) @ _QUARTER_TURN
        first = sideways @ self.starts.T - (sideways * origins).sum(axis=1)[:, np.newaxis]
        second = first + sideways @ self.spans.T
        return np.asarray(crosses & (first * second <= 0.0))

    def _crossed_cylinders(self, origins: FloatArray, targets: FloatArray) -> BoolArray:
        """(k, m): the sight line passes through the cylinder."""
        ways = targets - origins
        squared = np.maximum((ways * ways).sum(axis=1), TOUCH**2)[:, np.newaxis]
        dx, dy = ways[:, :1], ways[:, 1:]
        to_x, to_y = self.cylinders[:, 0] - origins[:, :1], self.cylinders[:, 1] - origins[:, 1:]
        nearest = np.minimum(np.maximum((to_x * dx + to_y * dy) / squared, 0.0), 1.0)
        misses = np.hypot(to_x - nearest * dx, to_y - nearest * dy)
        return np.asarray(misses < self.cylinders[:, 2] - TOUCH)

    def cast(self, origin: FloatArray, ray: FloatArray) -> tuple[float, int]:
        """Distance, m, of the first surface along a ray (unit vector), and the wall it is.

        inf where there is none; NO_WALL for cylinders and nothing.
        """
        on_walls = self.cast_on_walls(origin, ray[np.newaxis], slice(None))[0]
        distance = float(on_walls.min(initial=np.inf))
        on_cylinder = float(self._cast_on_cylinders(origin, ray).min(initial=np.inf))
        if on_cylinder <= distance:
            return on_cylinder, NO_WALL
        return distance, int(on_walls.argmin())

    def cast_on_walls(self, origin: FloatArray, rays: FloatArray, walls: IntArray | slice) -> FloatArray:
        """Distances (k, n), m, of some walls (n) along rays (k, 2) from one origin (2,); inf for a miss."""
        normals, along = self.normals[walls], self.along[walls]
        approach = rays @ normals.T
        approach[np.abs(approach) < _PARALLEL] = _PARALLEL
        distances = (self.offsets[walls] - normals @ origin) / approach
        reached = along @ origin - self.first_reached[walls] + distances * (rays @ along.T)
        hit = (distances > TOUCH) & (reached >= -TOUCH) & (reached <= self.lengths[walls] + TOUCH)
        return np.where(hit, distances, np.inf)

    def _cast_on_cylinders(self, origin: FloatArray, ray: FloatArray) -> FloatArray:
        """(m,) m; inf for a miss."""
        to_centres = self.cylinders[:, :2] - origin
        middle = to_centres @ ray
        inside = middle**2 - (to_centres**2).sum(axis=1) + self.cylinders[:, 2] ** 2
        distances = middle - np.sqrt(np.maximum(inside, 0.0))
        return np.where((inside >= 0.0) & (distances > TOUCH), distances, np.inf)

    def surface_distance(self, points: FloatArray) -> FloatArray:
        """Distance, m, of points (k, 2) from the nearest surface, as (k,)."""
        nearest = np.full(len(points), np.inf)
        for start, along, length in zip(self.starts, self.along, self.lengths, strict=True):
            foot = start + np.clip((points - start) @ along, 0.0, length)[:, np.newaxis] * along
            np.minimum(nearest, np.hypot(*(points - foot).T), out=nearest)
        for x, y, radius in self.cylinders:
            np.minimum(nearest, np.abs(np.hypot(*(points - (x, y)).T) - radius), out=nearest)
        return nearest
