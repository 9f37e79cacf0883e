"""A robot's recording in memory, from whichever format."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from echogrid.drivers.readings import RangeReading
from echogrid.mapping.pose import Pose
from echogrid.runtime import assembly, robot_file, simple_log
from echogrid.runtime.config import Config
from echogrid.runtime.errors import UsageError
from echogrid.runtime.simple_log import RowFaultError, RowFaults


@dataclass(slots=True)
class Recording:
    """All that a map is made from."""

    config: Config
    poses: list[tuple[int, Pose]] = field(default_factory=list)
    """Stamps (ns) and poses in the map frame, in order."""
    ranges: list[tuple[str, RangeReading]] = field(default_factory=list)
    """Where each reading stands (file:line), and the reading, as written."""
    faults: RowFaults = field(default_factory=RowFaults)


def read_simple(folder: Path) -> Recording:
    """A folder in the simple format. Raises UsageError with everything that keeps it from being read."""
    problems = simple_log.missing(folder)
    config = Config()
    try:
        config = robot_file.load(folder / "robot.toml")
    except UsageError as error:
        problems = [*error.problems, *problems]
    if problems:
        raise UsageError(problems)
    recording = Recording(config)
    has_poses = (folder / simple_log.POSES[0]).is_file()
    recording.poses = list(_poses(folder, recording) if has_poses else _reckoned(folder, recording))
    recording.ranges = list(_ranges(folder, recording))
    return recording


def _poses(folder: Path, recording: Recording) -> Iterator[tuple[int, Pose]]:
    last_ns: int | None = None
    for row in simple_log.rows(folder, simple_log.POSES, recording.faults):
        try:
            stamp_ns, pose = simple_log.pose(row.cells)
            last_ns = _later(stamp_ns, last_ns)
            yield stamp_ns, pose
        except RowFaultError as fault:
            recording.faults.add(str(fault), row.place)


def _reckoned(folder: Path, recording: Recording) -> Iterator[tuple[int, Pose]]:
    """Dead reckoning of wheels.csv."""
    drive = assembly.drive(recording.config)
    last_ns: int | None = None
    for row in simple_log.rows(folder, simple_log.WHEELS, recording.faults):
        try:
            angles = simple_log.wheel_angles(row.cells)
            last_ns = _later(angles.stamp_ns, last_ns)
            yield angles.stamp_ns, drive.update(angles.left, angles.right)
        except RowFaultError as fault:
            recording.faults.add(str(fault), row.place)


def _later(stamp_ns: int, last_ns: int | None) -> int:
    if last_ns is not None and stamp_ns <= last_ns:
        raise RowFaultError("pose not monotonic")
    return stamp_ns


def _ranges(folder: Path, recording: Recording) -> Iterator[tuple[str, RangeReading]]:
    rangers = {sensor.name: sensor.ranger() for sensor in recording.config.sensor}
    for row in simple_log.rows(folder, simple_log.RANGES, recording.faults):
        try:
            yield row.place, simple_log.range_reading(row.cells, rangers)
        except RowFaultError as fault:
            recording.faults.add(str(fault), row.place)
