"""A robot's recording in memory, from whichever format."""

from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from echogrid.drivers.readings import RangeReading
from echogrid.mapping.pose import Pose
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


def read_simple(folder: Path) -> Recording:
    """A folder in the simple format. Raises UsageError with everything that keeps it from being read."""
    problems = simple_log.missing(folder)
    config = Config()
    try:
        config = robot_file.load(folder / "robot.toml")
    except UsageError as error:
        problems = [*error.problems, *problems]
    reckoned = simple_log.way(folder) == simple_log.WHEELS
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


def wheel_rows(folder: Path, faults: RowFaults) -> list[tuple[int, WheelAngles]]:
    """The usable rows of wheels.csv with their stamps, in order; the others are added to the faults."""
    angles = _usable(folder, simple_log.WHEELS, faults, simple_log.wheel_angles)
    return monotonic([(place, each.stamp_ns, each) for place, each in angles], faults)


def _reckoned(folder: Path, recording: Recording) -> list[tuple[int, Pose]]:
    """Dead reckoning of wheels.csv."""
    in_order = wheel_rows(folder, recording.faults)
    odometry = assembly.odometry(recording.config)
    return [(stamp_ns, odometry.update(stamp_ns, (each.left, each.right))) for stamp_ns, each in in_order]


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
