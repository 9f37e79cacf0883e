"""Pings put to the test: which of the walls that look a ranger in the face were heard?

Sound comes back from a wall at the foot of the perpendicular, wherever in the beam that lies. Where nothing
else is about as far away, and nothing hides it, the reading tells whether that wall answered, and how far
off the axis it was.
"""

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from math import inf, isnan, nan, pi, radians

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.wall_faces import WallFaces
from echogrid.mapping.wall_refinement import WallEcho

Floats = NDArray[np.float64]
Index = NDArray[np.intp] | NDArray[np.bool_]
Foot = tuple[float, float, int]
"""Bearing (rad), distance (m), and the index of the face."""

WIDEST = radians(60.0)
"""Walls further off the axis are no trial."""
_NEAREST = 0.15
"""m: nearer walls are seen under too uncertain an angle."""
_BLIND = 0.05
"""m beyond the blanking distance."""
_END = 0.2
"""m before the reach: an echo from there may be told as none."""
_GROWTH = 0.03
"""A reading that differs from the wall's distance by a cell and this part of it is still the wall's."""
_SHADOW = radians(3.0)
"""What is so near the line to the wall hides it."""
_LEDGE = 0.1
"""m: what stands out so far from the wall is something else."""
_SAME_BEARING, _SAME_DISTANCE = radians(2.0), 0.1
"""rad and m: views that differ by less are one."""
_HEARD_FIRST = 0.3
"""m: walls so far behind what was heard are not looked for."""
_SAME_WALL = radians(10.0)
"""Faces whose bearings differ by less, at about one distance, are one wall."""
_OFF_CENTRE = 0.75
"""Cells: the foot of the perpendicular is in the cell, or nearly."""


@dataclass(frozen=True, slots=True)
class Trials:
    """What one ping says of one wall, each; arrays of shape (n,)."""

    sensor: NDArray[np.intp]
    """Which of the rangers."""
    stamp_ns: NDArray[np.int64]
    stretch: NDArray[np.intp]
    """Which stretch of time; pings of one are not independent."""
    reading: Floats
    """m; NaN: no echo."""
    agreeing: Floats
    """rad: how far off the axis the mapped surface is, the nearest to it, that agrees with the reading; inf:
    none does, nan: no echo."""
    bearing: Floats
    """rad, to the left: of the wall that is on trial; NaN: there is none, and the ping is no trial."""
    distance: Floats
    """m: of that wall."""
    tolerance: Floats
    """m: how far a reading of it may be off."""
    weight: Floats
    """Pings that look the same way at the same wall, one after the other, count as one view together."""
    first: NDArray[np.bool_]
    """Of each ping, which may have several, one."""

    def take(self, index: Index) -> "Trials":
        """Some of them."""
        return Trials(*(getattr(self, each.name)[index] for each in fields(self)))

    @property
    def on_trial(self) -> NDArray[np.bool_]:
        """Which have a wall that either answered or did not; one behind a nearer sound may have."""
        decided: NDArray[np.bool_] = ~np.isnan(self.bearing) & ~(
            self.reading < self.distance - self.tolerance
        )
        return decided

    @property
    def heard(self) -> NDArray[np.bool_]:
        """Whose wall answered."""
        answered: NDArray[np.bool_] = np.abs(self.reading - self.distance) <= self.tolerance
        return answered


@dataclass(frozen=True, slots=True)
class Ping:
    """One ping: see Trials."""

    sensor: int
    stamp_ns: int
    stretch: int
    reading: float


@dataclass(frozen=True, slots=True)
class View:
    """What one ping sees of the walls: see Trials."""

    agreeing: float
    bearing: float = nan
    distance: float = nan
    tolerance: float = nan


def trials(pings: Sequence[Ping], views: Sequence[View]) -> Trials:
    """Pings, in the order of time, with what each sees."""
    told = [[getattr(ping, each.name) for ping in pings] for each in fields(Ping)]
    sensor, stamp_ns, stretch = (np.array(column, np.int64) for column in told[:3])
    seen = np.array([astuple(view) for view in views], np.float64).reshape(-1, 4)
    agreeing, bearing, distance, tolerance = seen.T
    weight = _weights(np.stack((sensor, stretch)), bearing, distance)
    first = np.append(True, (np.diff(stamp_ns) != 0) | (np.diff(sensor) != 0))[: len(sensor)]
    reading = np.array(told[3], np.float64)
    return Trials(sensor, stamp_ns, stretch, reading, agreeing, bearing, distance, tolerance, weight, first)


def _weights(sensor_and_stretch: NDArray[np.int64], bearing: Floats, distance: Floats) -> Floats:
    """(n,) one over the number of pings of one ranger and stretch that look the same way at a wall equally
    far."""
    way = np.rint(np.nan_to_num(np.stack((bearing / _SAME_BEARING, distance / _SAME_DISTANCE))))
    places = np.concatenate((sensor_and_stretch, way))
    _, member, count = np.unique(places, axis=1, return_inverse=True, return_counts=True)
    result: Floats = 1.0 / count[member.ravel()]
    return result


def tried(faces: WallFaces, ranger: Ranger, transducer: Pose, reading: float) -> list[View]:
    """What a ping from there says of each wall that it can tell of, the reading (m) being NaN if nothing came
    back; of none, if there is none."""
    around = _Around(faces, transducer, ranger.farthest)
    agreeing = around.agreeing(reading)
    nearest = max(_NEAREST, ranger.nearest + _BLIND)
    farthest = ranger.farthest - _END
    if not isnan(reading):
        farthest = min(farthest, reading + _HEARD_FIRST)
    views = [
        View(agreeing, bearing, distance, around.allowed(distance))
        for bearing, distance, face in around.feet(nearest, farthest)
        if not around.hidden(bearing, distance) and not around.rivalled(face, distance)
    ]
    return views or [View(agreeing)]


def echoes_of(faces: WallFaces, ranger: Ranger, transducer: Pose, reading: float) -> list[WallEcho]:
    """What an echo tells of the walls that it may come from."""
    around = _Around(faces, transducer, ranger.farthest)
    allowed = around.allowed(reading) + 0.5 * faces.geometry.resolution
    return [
        WallEcho(face, transducer.x, transducer.y, reading)
        for bearing, distance, face in around.feet(reading - allowed, reading + allowed)
        if not around.hidden(bearing, distance)
    ]


class _Around:
    """A map as it lies around a transducer."""

    def __init__(self, faces: WallFaces, transducer: Pose, reach: float) -> None:
        self._faces, self._seat = faces, transducer
        self._cell = faces.geometry.resolution
        self._here = np.array((transducer.x, transducer.y))
        apart = faces.solid - self._here
        distance = np.hypot(apart[:, 0], apart[:, 1])
        near = distance <= reach + self.allowed(reach)
        self._solid, self._distance = faces.solid[near], distance[near]
        self._bearing = self._off_axis(apart[near])

    def allowed(self, distance: float) -> float:
        """How far a reading of a wall in that distance may be off, m."""
        return 0.5 * self._cell + 0.02 + _GROWTH * distance

    def agreeing(self, reading: float) -> float:
        """How far off the axis the nearest surface is that agrees with it, rad."""
        if isnan(reading):
            return nan
        fits = np.abs(self._distance - reading) <= self.allowed(reading)
        return float(np.min(np.abs(self._bearing), where=fits, initial=inf))

    def feet(self, nearest: float, farthest: float) -> list[Foot]:
        """The faces whose perpendicular comes through here, one of each wall."""
        faces = self._faces
        distance = np.einsum("ij,ij->i", self._here - faces.middles, faces.normals)
        apart = faces.cells - self._here
        aside = np.abs(apart[:, 0] * faces.normals[:, 1] - apart[:, 1] * faces.normals[:, 0])
        fits = (distance >= nearest) & (distance <= farthest) & (aside <= _OFF_CENTRE * self._cell)
        candidates = np.nonzero(fits)[0]
        bearings = self._off_axis(-faces.normals[candidates])
        ahead = np.abs(bearings) < WIDEST
        candidates, bearings = candidates[ahead], bearings[ahead]
        found: list[Foot] = []
        for at in np.lexsort((aside[candidates], np.rint(distance[candidates] / self._cell))):
            face = int(candidates[at])
            foot = float(bearings[at]), float(distance[face]), face
            if not any(self._same(foot, other) for other in found):
                found.append(foot)
        return found

    def _same(self, one: Foot, other: Foot) -> bool:
        """Whether both are of one wall."""
        apart = abs(one[1] - other[1])
        return abs(one[0] - other[0]) <= _SAME_WALL and apart <= 2.0 * self.allowed(other[1])

    def hidden(self, bearing: float, distance: float) -> bool:
        """Whether something stands before it."""
        beside = np.abs(self._bearing - bearing) < _SHADOW + self._cell / distance
        return bool(np.any(beside & (self._distance < distance - self.allowed(distance))))

    def rivalled(self, face: int, distance: float) -> bool:
        """Whether something else is about as far away, so that nobody knows what answered."""
        margin = 2.0 * self.allowed(distance)
        out = (self._solid - self._faces.middles[face]) @ self._faces.normals[face]
        other = (np.abs(self._bearing) < WIDEST) & (out > max(2.0 * self._cell, _LEDGE))
        return bool(np.any(other & (np.abs(self._distance - distance) < margin)))

    def _off_axis(self, vectors: Floats) -> Floats:
        """(n,) rad, to the left of the axis."""
        angles = np.arctan2(vectors[:, 1], vectors[:, 0]) - self._seat.yaw
        wrapped: Floats = (angles + pi) % (2.0 * pi) - pi
        return wrapped
