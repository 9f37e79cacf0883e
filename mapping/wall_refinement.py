"""A map's walls, drawn finer by the echoes that came from them.

Of a smooth wall each echo tells how far it is from the transducer, square to it: whatever its bearing and
whatever the mounting angle. From several places that makes the wall's line, far finer than cells are.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, radians, sin

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.wall_faces import Floats, WallFaces

_AROUND = 1.0
"""m: echoes of the same wall so far around a face draw it."""
_ALIKE = cos(radians(15.0))
_BESIDE = 1.0
"""Cells: faces further off the line are another wall's."""
_TURN, _SHIFT = radians(6.0), 0.5
"""rad and cells: how far off a face is, as a standard deviation, before its echoes are heard."""
_SPREAD = 0.02
"""m: of the echoes; what is further off than two of it counts less (Huber)."""
_ROUNDS = 3
_FEWEST = 6
"""Echoes, from places this far apart along the wall:"""
_BASE = 0.2
"""m."""
_LOOSEST = 0.03
"""m, the median of what the echoes are off the line: ghosts, which are heard where nothing is, have more."""


@dataclass(frozen=True, slots=True)
class WallEcho:
    """An echo that seems to come from a face."""

    face: int
    x: float
    """m, of the transducer, as is y."""
    y: float
    reading: float
    """m."""


def refined(faces: WallFaces, echoes: Sequence[WallEcho]) -> WallFaces:
    """The faces on the lines that their echoes draw; those that have too few, or no line, are left out."""
    heard = np.array([each.face for each in echoes], np.intp)
    places = np.array([(each.x, each.y) for each in echoes]).reshape(-1, 2)
    readings = np.array([each.reading for each in echoes])
    middles, normals = faces.middles.copy(), faces.normals.copy()
    kept = np.zeros(len(faces.cells), np.bool_)
    for index in range(len(faces.cells)):
        mine = _kin(faces, index)[heard]
        if np.count_nonzero(mine) >= _FEWEST:
            middles[index], normals[index] = _line(faces, index, places[mine], readings[mine])
            kept[index] = _is_line(middles[index], normals[index], places[mine], readings[mine])
    return replace(faces, cells=faces.cells[kept], middles=middles[kept], normals=normals[kept])


def _is_line(middle: Floats, normal: Floats, places: Floats, readings: Floats) -> bool:
    """Whether the echoes tell of this line, from more than one place."""
    apart = places - middle
    along = apart @ np.array((-normal[1], normal[0]))
    off = np.abs(readings - apart @ normal)
    return bool(np.median(off) <= _LOOSEST and np.ptp(along) >= _BASE)


def _kin(faces: WallFaces, index: int) -> NDArray[np.bool_]:
    """(n,) which faces are of the same straight wall, and near."""
    apart = faces.cells - faces.cells[index]
    normal = faces.normals[index]
    near = np.hypot(apart[:, 0], apart[:, 1]) <= _AROUND
    level = np.abs(apart @ normal) <= _BESIDE * faces.geometry.resolution
    kin: NDArray[np.bool_] = near & level & (faces.normals @ normal >= _ALIKE)
    return kin


def _line(faces: WallFaces, index: int, places: Floats, readings: Floats) -> tuple[Floats, Floats]:
    """Middle and normal: least squares over turn and shift, which are small, and not believed large."""
    normal, middle = faces.normals[index], faces.middles[index]
    tangent = np.array((-normal[1], normal[0]))
    apart = places - middle
    design = np.column_stack((apart @ tangent, -np.ones(len(places)))) / _SPREAD
    missing = (readings - apart @ normal) / _SPREAD
    prior = np.diag((_TURN**-2, (_SHIFT * faces.geometry.resolution) ** -2))
    found = np.zeros(2)
    for _ in range(_ROUNDS):
        left = np.abs(missing - design @ found)
        weight = np.where(left <= 2.0, 1.0, 2.0 / np.maximum(left, 2.0))
        found = np.linalg.solve(
            design.T @ (design * weight[:, np.newaxis]) + prior, design.T @ (missing * weight)
        )
    turn, shift = found
    turned = normal * cos(turn) + tangent * sin(turn)
    return middle + shift * normal, turned / np.hypot(*turned)
