"""How well a map draws the straight side walls of the RoboND recording, for which there is no other truth.

The walls are least-squares lines through the near echoes of the two side sonars while the robot drives
about straight on; a wall's bin is drawn if an occupied cell lies near it.
"""

from dataclasses import dataclass
from math import radians

import numpy as np
from numpy.typing import NDArray

from echogrid.drivers.readings import Outcome
from echogrid.mapping.long_term_map import MapImage
from echogrid.runtime.recording import Recording

_NEAR_ECHO_M = 2.5
_STRAIGHT = radians(20.0)
_BIN_M = 0.1
_NEAR_WALL_M = 0.1
_NEAR_PATH_M = 0.15
_OCCUPIED = 0.65

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class WallScore:
    """What was found."""

    bins: int
    """Bins of 10 cm along both walls that have echoes."""
    drawn: float
    """The part of them with an occupied cell within 10 cm."""
    path_blocked: float
    """The part of the known cells within 15 cm of the driven path which are occupied."""


def side_walls(recording: Recording, right: str, left: str) -> list[Points]:
    """For each side the middles, (n, 2) in m, of the wall's bins that have echoes."""
    return [_bins(_echoes(recording, name)) for name in (right, left)]


def score(image: MapImage, walls: list[Points], path: Points) -> WallScore:
    """How the map draws these walls, and whether it blocks the (n, 2) path (m) that was driven."""
    middles = np.concatenate(walls)
    rows, cols = np.nonzero((image.occupancy >= _OCCUPIED) & ~image.unknown)
    occupied = _centres(image, rows, cols)
    known_rows, known_cols = np.nonzero(~image.unknown)
    beside = _distance(_centres(image, known_rows, known_cols), path) <= _NEAR_PATH_M
    blocked = image.occupancy[known_rows, known_cols][beside] >= _OCCUPIED
    return WallScore(
        len(middles), float(np.mean(_distance(middles, occupied) <= _NEAR_WALL_M)), float(np.mean(blocked))
    )


def _echoes(recording: Recording, sensor: str) -> Points:
    """Where the sensor's near echoes lie while the robot drives about straight on, (n, 2) m."""
    poses = dict(recording.poses)
    ranger = next(s.ranger() for s in recording.config.sensor if s.name == sensor)
    points = []
    for _, reading in recording.ranges:
        pose = poses.get(reading.stamp_ns)
        near = (
            reading.sensor == sensor and reading.outcome is Outcome.ECHO and reading.distance < _NEAR_ECHO_M
        )
        if near and pose is not None and abs(pose.yaw) < _STRAIGHT:
            transducer = pose.compose(ranger.mount)
            reach = reading.distance * np.array([np.cos(transducer.yaw), np.sin(transducer.yaw)])
            points.append(np.array([transducer.x, transducer.y]) + reach)
    return np.array(points).reshape(-1, 2)


def _bins(echoes: Points) -> Points:
    slope, offset = np.polyfit(echoes[:, 0], echoes[:, 1], 1)
    along = np.array([1.0, slope]) / np.hypot(1.0, slope)
    start = np.array([0.0, offset])
    places = np.unique(np.floor((echoes - start) @ along / _BIN_M))
    middles: Points = start + np.outer((places + 0.5) * _BIN_M, along)
    return middles


def _centres(image: MapImage, rows: NDArray[np.intp], cols: NDArray[np.intp]) -> Points:
    return np.column_stack([image.geometry.x_centres[cols], image.geometry.y_centres[rows]])


def _distance(points: Points, others: Points) -> NDArray[np.float64]:
    """From each point to the nearest of the others; in portions, to stay small."""
    portions = np.array_split(points, max(1, len(points) * len(others) // 4_000_000 + 1))
    return np.concatenate(
        [
            np.sqrt(((p[:, np.newaxis] - others) ** 2).sum(axis=2)).min(axis=1, initial=np.inf)
            for p in portions
        ]
    )
