"""The RoboND occupancy-grid recording: a real robot with eight sonars.

measurement.txt: t [ms] and eight ranges [mm]; poses.txt: t [ms], x [mm], y [mm], heading [0.1 deg]. A range
of 5000 or more is no echo. The sonars' offsets are not published: all stand at the robot's centre.
"""

from collections.abc import Iterator
from math import radians
from pathlib import Path

from echogrid.drivers.readings import RangeReading, classify
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.runtime.config import Config, MapConfig
from echogrid.runtime.errors import UsageError
from echogrid.runtime.hardware_config import SensorConfig
from echogrid.runtime.recording import ROBOND_RANGES, Recording, monotonic
from echogrid.runtime.simple_log import RowFaults

BEARINGS_DEG = (-90.0, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90.0)
_MILLISECOND_NS = 1_000_000
_LARGEST = 10**12
"""ms or mm; beyond that a row is nonsense."""


def configuration(bearings_deg: tuple[float, ...] = BEARINGS_DEG) -> Config:
    """The robot: half angle 10 degrees, reach 5 m, cells of 5 cm."""
    sensors = tuple(
        SensorConfig(f"sonar{index}", 0.0, 0.0, bearing, 10.0, 0.0, 5.0)
        for index, bearing in enumerate(bearings_deg)
    )
    return Config(sensor=sensors, map=MapConfig(resolution_m=0.05, tolerance_m=0.1))


def read(folder: Path, config: Config | None = None) -> Recording:
    """The recording in a folder. Raises UsageError when a file is missing."""
    paths = folder / ROBOND_RANGES, folder / "poses.txt"
    absent = [f"{path}: no such file" for path in paths if not path.is_file()]
    if absent:
        raise UsageError(absent)
    recording = Recording(config or configuration())
    recording.poses = monotonic(list(_poses(paths[1], recording.faults)), recording.faults)
    recording.ranges = list(_ranges(paths[0], recording))
    return recording


def _poses(path: Path, faults: RowFaults) -> Iterator[tuple[str, int, Pose]]:
    for place, (millis, x, y, heading) in _rows(path, 4, faults):
        pose = Pose(x * 1e-3, y * 1e-3, wrap_angle(radians(heading / 10.0)))
        yield place, millis * _MILLISECOND_NS, pose


def _ranges(path: Path, recording: Recording) -> Iterator[tuple[str, RangeReading]]:
    sensors = recording.config.sensor
    for place, (millis, *ranges) in _rows(path, 1 + len(sensors), recording.faults):
        if min(ranges) < 0:
            recording.faults.add("negative range", place)
            continue
        for sensor, millimetres in zip(sensors, ranges, strict=True):
            outcome, distance = classify(millimetres * 1e-3, sensor.min_m, sensor.max_m)
            yield place, RangeReading(millis * _MILLISECOND_NS, 0, sensor.name, outcome, distance)


def _rows(path: Path, columns: int, faults: RowFaults) -> Iterator[tuple[str, list[int]]]:
    with path.open(encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, 1):
            try:
                values = [int(word) for word in line.split()]
            except ValueError:
                values = []
            if len(values) == columns and all(abs(value) <= _LARGEST for value in values):
                yield f"{path}:{number}", values
            elif line.strip():
                faults.add("unparsable", f"{path}:{number}")
