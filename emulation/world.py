"""What there is around the robot: walls, posts, people and the air, in one plane."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import compress
from math import ceil, floor, hypot, tau
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.ear import Ear
from echogrid.emulation.glimpse import SECTORS, Panorama, Square
from echogrid.emulation.notches import find_notches
from echogrid.emulation.vista import TOUCH, Barrier, Notch, Post, Vista, Wall
from echogrid.emulation.walker import Walker

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

_QUARTER_TURN = np.array(((0.0, 1.0), (-1.0, 0.0)))
_CELL = 0.5
"""m: the floor is cut into squares, and what can be seen from each is found when it is first asked for."""
_PER_SECTOR = SECTORS / tau
_UNIT_SQUARE = np.array(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))
_PARALLEL = 1e-12
_FACET = 0.1
"""m: pieces of rough walls are no longer."""


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
    wall_softness: FloatArray | None = None
    """(n,) float64, dB that each wall takes from the sound it returns (upholstery: 10 to 15); None: 0."""
    cylinder_softness: FloatArray | None = None
    """(m,) float64, dB, of the cylinders; None: 0."""
    walkers: tuple[Walker, ...] = ()
    """People: they hide and reflect, but are no part of the map."""

    def at(self, time_s: float) -> "Moment":
        """The world at a time since its beginning."""
        if time_s not in self._moments:
            self._moments.clear()
            self._moments[time_s] = Moment(self, tuple(walker.at(time_s) for walker in self.walkers))
        return self._moments[time_s]

    @cached_property
    def _moments(self) -> dict[float, "Moment"]:
        """The one last asked for, as rangers that fire together ask one after the other."""
        return {}

    @cached_property
    def softness(self) -> FloatArray:
        """(n,) dB, of the walls."""
        return np.zeros(len(self.walls)) if self.wall_softness is None else self.wall_softness

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

    def vista_at(self, x: float, y: float) -> Vista:
        """What may be seen from around a place."""
        cell = floor(x / _CELL), floor(y / _CELL)
        vista = self._vistas.get(cell)
        if vista is None:
            corners = _CELL * (_UNIT_SQUARE + cell)
            vista = self._vistas[cell] = self.everything.seen_from(corners)
        return vista

    def glimpse_at(self, x: float, y: float, yaw: float, ear: Ear) -> Vista:
        """What of it an ear that looks in a direction, rad, may meet."""
        key = floor(x / _CELL), floor(y / _CELL), floor(yaw * _PER_SECTOR) % SECTORS
        glimpses = self._glimpses.get(ear)
        if glimpses is None:
            glimpses = self._glimpses[ear] = {}
        seen = glimpses.get(key)
        if seen is None:
            col, row, sector = key
            seen = glimpses[key] = self._panorama(ear, col, row).glimpse(sector)
        return seen

    def _panorama(self, ear: Ear, col: int, row: int) -> Panorama:
        panorama = self._panoramas.get((ear, col, row))
        if panorama is None:
            middle = (col + 0.5) * _CELL, (row + 0.5) * _CELL
            square = Square(*middle, hypot(0.5, 0.5) * _CELL)
            panorama = self._panoramas[ear, col, row] = Panorama(self.vista_at(*middle), square, ear)
        return panorama

    def vista_of(self, wall: int) -> Vista:
        """What may be seen from a wall."""
        vista = self._wall_vistas.get(wall)
        if vista is None:
            vista = self._wall_vistas[wall] = self.everything.seen_from(self.walls[wall].reshape(2, 2))
        return vista

    def facets(self, wall: int) -> tuple[Notch, ...]:
        """Both faces of a wall in pieces, as far as sound from outside them is concerned."""
        facets = self._facets.get(wall)
        if facets is None:
            facets = self._facets[wall] = tuple(self._cut(self.everything.walls[wall]))
        return facets

    @staticmethod
    def _cut(wall: Wall) -> Iterator[Notch]:
        count = ceil(wall.length / _FACET)
        for index in range(count):
            along = wall.first_reached + (index + 0.5) * wall.length / count
            x = wall.offset * wall.normal_x + along * wall.along_x
            y = wall.offset * wall.normal_y + along * wall.along_y
            yield Notch(x, y, wall.normal_x, wall.normal_y, 0.0, wall.softness)
            yield Notch(x, y, -wall.normal_x, -wall.normal_y, 0.0, wall.softness)

    @cached_property
    def _facets(self) -> dict[int, tuple[Notch, ...]]:
        return {}

    @cached_property
    def _glimpses(self) -> dict[Ear, dict[tuple[int, int, int], Vista]]:
        return {}

    @cached_property
    def _panoramas(self) -> dict[tuple[Ear, int, int], Panorama]:
        return {}

    @cached_property
    def _vistas(self) -> dict[tuple[int, int], Vista]:
        return {}

    @cached_property
    def _wall_vistas(self) -> dict[int, Vista]:
        return {}

    @cached_property
    def everything(self) -> Vista:
        """What may be seen from everywhere."""
        lines = np.column_stack((self.normals, self.offsets))
        stretches = np.column_stack((self.along, self.first_reached, self.lengths, self.softness))
        walls = tuple(Wall(number, *row) for number, row in enumerate(np.hstack((lines, stretches)).tolist()))
        barriers = np.hstack((lines, self.starts, self.spans)).tolist()
        notches = find_notches(self.walls, self.rough, self.softness)
        cones = np.column_stack((notches.points, notches.middle, notches.cosine, notches.softness))
        softness = np.zeros(len(self.cylinders)) if self.cylinder_softness is None else self.cylinder_softness
        posts = np.column_stack((self.cylinders, softness))
        return Vista(
            walls,
            tuple(Barrier(*row) for row in barriers),
            tuple(compress(walls, ~self.rough)),
            tuple(compress(walls, self.rough)),
            tuple(Notch(*row) for row in cones[notches.corner].tolist()),
            tuple(Notch(*row) for row in cones[~notches.corner].tolist()),
            tuple(Post(*row) for row in posts.tolist()),
        )

    def line_of_sight(self, origins: FloatArray, targets: FloatArray) -> BoolArray:
        """Whether nothing stands between origins (k, 2) and targets (k, 2), as (k,).

        A surface on which either lies does not count.
        """
        ways = zip(origins.tolist(), targets.tolist(), strict=True)
        return np.array([self.vista_at(*here).clear(here, there) for here, there in ways], dtype=np.bool_)

    def cast(self, origin: FloatArray, ray: FloatArray) -> tuple[float, int]:
        """Distance, m, of the first surface along a ray (unit vector), and the wall it is.

        inf where there is none; NO_WALL for cylinders and nothing.
        """
        x, y = origin.tolist()
        return self.vista_at(x, y).cast((x, y), ray.tolist())

    def cast_on_walls(self, origin: FloatArray, rays: FloatArray, walls: IntArray | slice) -> FloatArray:
        """Distances (k, n), m, of some walls (n) along rays (k, 2) from one origin (2,); inf for a miss."""
        normals, along = self.normals[walls], self.along[walls]
        approach = rays @ normals.T
        approach[np.abs(approach) < _PARALLEL] = _PARALLEL
        distances = (self.offsets[walls] - normals @ origin) / approach
        reached = along @ origin - self.first_reached[walls] + distances * (rays @ along.T)
        hit = (distances > TOUCH) & (reached >= -TOUCH) & (reached <= self.lengths[walls] + TOUCH)
        return np.where(hit, distances, np.inf)

    def surface_distance(self, points: FloatArray) -> FloatArray:
        """Distance, m, of points (k, 2) from the nearest surface, as (k,)."""
        nearest = np.full(len(points), np.inf)
        for start, along, length in zip(self.starts, self.along, self.lengths, strict=True):
            foot = start + np.clip((points - start) @ along, 0.0, length)[:, np.newaxis] * along
            np.minimum(nearest, np.hypot(*(points - foot).T), out=nearest)
        for x, y, radius in self.cylinders:
            np.minimum(nearest, np.abs(np.hypot(*(points - (x, y)).T) - radius), out=nearest)
        return nearest


class Moment(NamedTuple):
    """A world at one time: what stands, and who walks by."""

    world: World
    people: tuple[Post, ...]

    def vista_at(self, x: float, y: float) -> Vista:
        """What may be seen from around a place, and everybody."""
        return self._peopled(self.world.vista_at(x, y))

    def glimpse_at(self, x: float, y: float, yaw: float, ear: Ear) -> Vista:
        """What of it an ear that looks in a direction, rad, may meet, and everybody."""
        return self._peopled(self.world.glimpse_at(x, y, yaw, ear))

    def vista_of(self, wall: int) -> Vista:
        """What may be seen from a wall, and everybody."""
        return self._peopled(self.world.vista_of(wall))

    def _peopled(self, vista: Vista) -> Vista:
        return Vista(*vista[:-1], vista.posts + self.people) if self.people else vista
