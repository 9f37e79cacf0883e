"""A robot's recording in memory, from whichever format."""

from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from echogrid.drivers.readings import RangeReading
from echogrid.mapping.kinematics import Wheels
from echogrid.mapping.pose import Pose
from echogrid.mapping.reckoning import Reckoning, YawRate
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime import assembly, robot_file, simple_log
from echogrid.runtime.config import Config
from echogrid.runtime.errors import ConfigError, UsageError
from echogrid.runtime.simple_log import RowFaultError, RowFaults

T = TypeVar("T")


@dataclass(slots=True)
class Recording:
    """All that a map is made from."""

    config: Config
    poses: list[tuple[int, Pose]] = field(default_factory=list)
    """Stamps (ns) and poses in the map frame, in order."""
    ranges: list[tuple[str, RangeReading]] = field(default_factory=list)
    """Where each reading stands (file:line), and the reading, as written."""
    faults: RowFaults = field(default_factory=RowFaults)


ROBOND_RANGES = "measurement.txt"
"""By which that recording is told from ours."""


def read_simple(folder: Path) -> Recording:
    """A folder in the simple format. Raises UsageError with everything that keeps it from being read."""
    if not folder.is_dir():
        raise UsageError([f"{folder}: no such folder"])
    if (folder / ROBOND_RANGES).is_file() and not (folder / simple_log.RANGES[0]).is_file():
        raise UsageError([f"{folder}: no log of ours, but like RoboND's recording: try --format robond"])
    config = Config()
    try:
        config = robot_file.load(folder / "robot.toml")
        problems = simple_log.missing(folder, config.robot.wheels)
    except UsageError as error:
        problems = [*error.problems, *simple_log.missing(folder, None)]
    reckoned = not simple_log.has_poses(folder)
    if reckoned and not problems:
        try:
            assembly.drive(config)
        except ConfigError as error:
            problems = [f"{folder}/{problem}" for problem in error.problems]
    if problems:
        raise UsageError(problems)
    recording = Recording(config)
    recording.poses = _reckoned(folder, recording) if reckoned else _poses(folder, recording)
    recording.ranges = list(_ranges(folder, recording))
    return recording


def monotonic(entries: Sequence[tuple[str, int, T]], faults: RowFaults) -> list[tuple[int, T]]:
    """Stamps and values of the entries (place, stamp, value) in order, the fewest others skipped: one stamp
    far ahead costs one row. Where there is a choice the earlier row stays."""
    wanted = _longest_rises([stamp_ns for _, stamp_ns, _ in entries])
    left = max(wanted, default=0)
    kept: list[tuple[int, T]] = []
    for (place, stamp_ns, value), rise in zip(entries, wanted, strict=True):
        if rise == left and (not kept or stamp_ns > kept[-1][0]):
            kept.append((stamp_ns, value))
            left -= 1
        else:
            faults.add("pose not monotonic", place)
    return kept


def _longest_rises(stamps_ns: Sequence[int]) -> list[int]:
    """For each stamp, how many there are in the longest rising sequence which begins with it."""
    rises: list[int] = []
    latest_starts: list[int] = []  # Of the rising sequences of 1, 2, ... stamps so far, negative.
    for stamp_ns in reversed(stamps_ns):
        length = bisect_left(latest_starts, -stamp_ns)
        latest_starts[length : length + 1] = [-stamp_ns]
        rises.append(length + 1)
    return rises[::-1]


def _poses(folder: Path, recording: Recording) -> list[tuple[int, Pose]]:
    poses = _usable(folder, simple_log.POSES, recording.faults, simple_log.pose)
    return monotonic([(place, stamp_ns, pose) for place, (stamp_ns, pose) in poses], recording.faults)


def wheel_rows(folder: Path, wheels: Wheels, faults: RowFaults) -> list[tuple[int, WheelAngles]]:
    """The usable rows of wheels.csv with their stamps, in order; the others are added to the faults."""
    more = (simple_log.RESTARTED,) if simple_log.tells_restarts(folder) else ()
    angles = _usable(folder, simple_log.wheel_table(wheels, more), faults, simple_log.wheel_angles)
    return monotonic([(place, each.stamp_ns, each) for place, each in angles], faults)


def _reckoned(folder: Path, recording: Recording) -> list[tuple[int, Pose]]:
    """Dead reckoning of wheels.csv, and gyro.csv if it is there."""
    reckoning = Reckoning(assembly.odometry(recording.config))
    entries: list[tuple[int, YawRate | WheelAngles]] = [
        *wheel_rows(folder, recording.config.robot.wheels, recording.faults)
    ]
    if recording.config.gyro and (folder / simple_log.GYRO[0]).is_file():
        entries += _rates(folder, recording.faults)
    poses: list[tuple[int, Pose]] = []
    for _, entry in sorted(entries, key=_by_stamp_rates_first):
        _ = reckoning.rate(entry) if isinstance(entry, YawRate) else reckoning.wheels(entry)
        poses += reckoning.poses()
    return poses + reckoning.finish()


def _by_stamp_rates_first(entry: tuple[int, YawRate | WheelAngles]) -> tuple[int, bool]:
    return entry[0], isinstance(entry[1], WheelAngles)


def _rates(folder: Path, faults: RowFaults) -> list[tuple[int, YawRate]]:
    rates = _usable(folder, simple_log.GYRO, faults, simple_log.yaw_rate)
    return monotonic([(place, each.stamp_ns, each) for place, each in rates], faults)


def _ranges(folder: Path, recording: Recording) -> Iterator[tuple[str, RangeReading]]:
    rangers = {sensor.name: sensor.ranger() for sensor in recording.config.sensor}
    return _usable(
        folder, simple_log.RANGES, recording.faults, lambda cells: simple_log.range_reading(cells, rangers)
    )


def _usable(
    folder: Path, table: simple_log.Table, faults: RowFaults, read: Callable[[tuple[str, ...]], T]
) -> Iterator[tuple[str, T]]:
    """Where each row stands and what is read from it; those which can't be read are skipped."""
    for row in simple_log.rows(folder, table, faults):
        try:
            yield row.place, read(row.cells)
        except RowFaultError as fault:
            faults.add(str(fault), row.place)
