"""The walls by which a log's rangers are judged: of a map that is known, or of the log's own."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, hypot, tau
from pathlib import Path

import numpy as np

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.emulation.offices import office
from echogrid.emulation.world import World
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.pose_buffer import PoseBuffer
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.wall_faces import Floats, WallFaces, faces_of
from echogrid.mapping.wall_refinement import refined
from echogrid.mapping.wall_trials import echoes_of
from echogrid.runtime import assembly, offline, truth_map
from echogrid.runtime.office_truth import in_office
from echogrid.runtime.recording import Recording
from echogrid.runtime.truth_map import TruthMap

STRETCH_NS = 10_000_000_000
"""Pings of one stretch of time are no independent witnesses. Every other one is in the other half."""
SURE = 0.97
"""What its own map calls walls with less than that is none yet: where it has heard little it goes on with
walls as they mostly do, and what did not answer there would be held against the beam."""
_FINE = 0.05
"""m: so far apart are the points which an emulated wall is made of."""
_COARSE = 0.3
"""Cells: by what the walls of a given map may be off, on the mean."""
_REFINEMENTS = 2


@dataclass(frozen=True, slots=True)
class LoggedPing:
    """An echo or silence, and where its ranger was."""

    sensor: int
    """Which of the configuration's."""
    reading: RangeReading
    robot: Pose
    ranger: Ranger
    stretch: int
    """Of time, counted from the log's first pose."""

    @property
    def transducer(self) -> Pose:
        """In the log's frame."""
        return self.robot.compose(self.ranger.mount)

    @property
    def echo(self) -> float | None:
        """m; None: nothing came back."""
        return self.reading.distance if self.reading.outcome is Outcome.ECHO else None


@dataclass(frozen=True, slots=True)
class Reference:
    """The maps by which pings of even and odd stretches are judged."""

    maps: tuple[TruthMap, TruthMap]
    faces: tuple[WallFaces, WallFaces]
    own: bool
    """Made from the log, each from the other half."""
    off: float = 0.0
    """m: the standard error of where the walls of a map stand, all in all."""

    def of(self, ping: LoggedPing) -> tuple[TruthMap, WallFaces]:
        """The map, and its walls' faces, by which a ping is judged."""
        return self.maps[ping.stretch % 2], self.faces[ping.stretch % 2]


def placed(recording: Recording) -> list[LoggedPing]:
    """All echoes and silences of which it is known where the robot was, in the order of time."""
    config = recording.config
    poses = PoseBuffer(None, assembly.pose_gap_ns(config))
    for stamp_ns, pose in recording.poses:
        poses.add(stamp_ns, pose)
    places = {sensor.name: index for index, sensor in enumerate(config.sensor)}
    rangers = [sensor.ranger() for sensor in config.sensor]
    result = []
    for _, reading in sorted(recording.ranges, key=lambda entry: entry[1].stamp_ns):
        robot = poses.at(reading.stamp_ns)
        usable = reading.outcome in (Outcome.ECHO, Outcome.NO_ECHO) and not reading.listened
        if isinstance(robot, Pose) and usable and reading.sensor in places:
            sensor = places[reading.sensor]
            stretch = _stretch(recording, reading)
            result.append(LoggedPing(sensor, reading, robot, rangers[sensor], stretch))
    return result


def in_known(recording: Recording, path: Path) -> tuple[Recording, Reference]:
    """By the map in a file. Raises UsageError."""
    truth = truth_map.read(path)
    return recording, known(truth, faces_of(truth.geometry, truth.walls), _COARSE * truth.geometry.resolution)


def in_emulated(recording: Recording) -> tuple[Recording, Reference]:
    """By the built-in office; the poses are then in its frame. Raises UsageError for a log of elsewhere."""
    recording, office_truth = in_office(recording)
    xs, ys = ([getattr(pose, axis) for _, pose in recording.poses] for axis in ("x", "y"))
    reach = max(sensor.max_m for sensor in recording.config.sensor) + 1.0
    cell = recording.config.map.resolution_m
    area = GridGeometry.covering(min(xs) - reach, min(ys) - reach, max(xs) + reach, max(ys) + reach, cell)
    return recording, known(TruthMap(area, *office_truth.on(area)), faces_of_world(office()))


def known(truth: TruthMap, faces: WallFaces, off: float = 0.0) -> Reference:
    """By one map, which owes the log nothing."""
    return Reference((truth, truth), (faces, faces), own=False, off=off)


def faces_of_world(world: World) -> WallFaces:
    """The faces of an emulated world's walls, on both sides, exactly where they are."""
    rounds = [_round(*post) for post in world.cylinders.tolist()]
    points, normals = [], []
    for x0, y0, x1, y1 in world.walls.tolist():
        length = hypot(x1 - x0, y1 - y0)
        along = (np.arange(ceil(length / _FINE)) + 0.5) / ceil(length / _FINE)
        points.append(np.column_stack((x0 + along * (x1 - x0), y0 + along * (y1 - y0))))
        normals.append(np.tile(((y0 - y1) / length, (x1 - x0) / length), (len(along), 1)))
    walls, left = np.concatenate(points), np.concatenate(normals)
    both = np.concatenate((walls, walls))
    geometry = GridGeometry(_FINE, 0.0, 0.0, 1, 1)
    solid = np.concatenate((walls, *rounds))
    return WallFaces(geometry, solid, both, both, np.concatenate((left, -left)))


def _round(x: float, y: float, radius: float) -> Floats:
    angles = np.linspace(0.0, tau, max(ceil(tau * radius / _FINE), 4), endpoint=False)
    return np.column_stack((x + radius * np.cos(angles), y + radius * np.sin(angles)))


def of_itself(recording: Recording, pings: Sequence[LoggedPing]) -> Reference:
    """By the log's own map: of each half of its stretches, the other half's. Raises UsageError."""
    maps = _made_from(recording, 1), _made_from(recording, 0)
    even, odd = (_drawn(each, pings) for each in maps)
    return Reference(maps, (even, odd), own=True)


def _made_from(recording: Recording, parity: int) -> TruthMap:
    """The map of the pings of even (0) or odd (1) stretches alone."""
    part = [entry for entry in recording.ranges if _stretch(recording, entry[1]) % 2 == parity]
    image = offline.build(replace(recording, ranges=part)).image
    walls, free = (~image.unknown & each for each in (image.occupancy > SURE, image.occupancy < 1.0 - SURE))
    return TruthMap(image.geometry, walls, free)


def _drawn(truth: TruthMap, pings: Sequence[LoggedPing]) -> WallFaces:
    """Its faces, drawn finer by all echoes."""
    faces = faces_of(truth.geometry, truth.walls)
    for _ in range(_REFINEMENTS):
        echoes = [
            wall
            for ping in pings
            if ping.echo is not None
            for wall in echoes_of(faces, ping.ranger, ping.transducer, ping.echo)
        ]
        faces = refined(faces, echoes)
    return faces


def _stretch(recording: Recording, reading: RangeReading) -> int:
    first_ns = recording.poses[0][0] if recording.poses else 0
    return (reading.stamp_ns - first_ns) // STRETCH_NS
