"""The simple log: a folder with robot.toml, ranges.csv and poses.csv, or wheels.csv and perhaps gyro.csv."""

import csv
from collections.abc import Iterator
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from math import inf, isfinite, isinf, isnan, nan
from pathlib import Path

from echogrid.drivers.readings import Outcome, RangeReading, classify
from echogrid.mapping.kinematics import Wheels
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.reckoning import YawRate
from echogrid.mapping.wheel_pair import WheelAngles

Table = tuple[str, tuple[str, ...]]
"""A file's name, and its columns."""

RANGES = "ranges.csv", ("stamp_s", "sensor", "range_m")
WHEELS = "wheels.csv"
"""Its columns are those of the drive."""
RESTARTED = "restarted"
"""A column of it that may be missing: 1 where a wheel was led on with zero motion, else 0."""
GYRO = "gyro.csv", ("stamp_s", "rate_rad_s")
POSES = "poses.csv", ("stamp_s", "x_m", "y_m", "yaw_rad")

_FARTHEST_STAMP_S = 4_000_000_000
"""A century and more around 1970; beyond that a stamp is nonsense."""
_LARGEST = 1e9
"""m or rad; beyond that a pose or an angle is nonsense."""


@dataclass(slots=True)
class RowFaults:
    """Rows that had to be skipped: how many for each reason, and where the first one stands."""

    counts: dict[str, int] = field(default_factory=dict)
    first: dict[str, str] = field(default_factory=dict)

    def add(self, reason: str, place: str) -> None:
        """Count a row."""
        self.counts[reason] = self.counts.get(reason, 0) + 1
        self.first.setdefault(reason, place)

    def lines(self) -> list[str]:
        """One line for each reason."""
        return [
            f"{self.first[reason]}: {reason}: {count} row{'s' if count > 1 else ''} skipped from here on"
            for reason, count in self.counts.items()
        ]


class RowFaultError(Exception):
    """A row which can't be used, and why."""


@dataclass(frozen=True, slots=True)
class Row:
    """The wanted columns of one line."""

    place: str
    """file:line."""
    cells: tuple[str, ...]


def missing(folder: Path, wheels: Wheels | None) -> list[str]:
    """The files, and columns of their headers, that a log folder lacks, one line each."""
    problems = unusable(folder, RANGES)
    if has_poses(folder):
        problems += unusable(folder, POSES)
    elif (folder / WHEELS).is_file():
        problems += unusable_wheels(folder, wheels)
    else:
        says = "one of them says where the robot was"
        return [*problems, f"{folder}: neither {POSES[0]} nor {WHEELS}: {says}"]
    return problems + (unusable(folder, GYRO) if (folder / GYRO[0]).is_file() else [])


def unusable(folder: Path, table: Table) -> list[str]:
    """What keeps a table from being read, if anything: the file, or columns of its header, are not there."""
    name, columns = table
    if not (folder / name).is_file():
        return [f"{folder / name}: no such file"]
    if absent := set(columns) - set(_header(folder / name)):
        lacking = ", ".join(column for column in columns if column in absent)
        return [f"{folder / name}:1: the header lacks {lacking}: it must be {','.join(columns)}"]
    return []


def unusable_wheels(folder: Path, wheels: Wheels | None) -> list[str]:
    """The same of wheels.csv; which columns it must have is not known (None) without the kind of drive."""
    return unusable(folder, wheel_table(wheels) if wheels else (WHEELS, ()))


def wheel_table(wheels: Wheels, more: tuple[str, ...] = ()) -> Table:
    """The wheels.csv of such a drive, with more columns."""
    return WHEELS, ("stamp_s", f"{wheels.first}_rad", f"{wheels.second}_rad", *more)


def has_poses(folder: Path) -> bool:
    """Whether its poses say where the robot was, and not its wheels."""
    return (folder / POSES[0]).is_file()


def tells_restarts(folder: Path) -> bool:
    """Whether its wheels.csv does."""
    return RESTARTED in _header(folder / WHEELS)


def rows(folder: Path, table: Table, faults: RowFaults) -> Iterator[Row]:
    """The rows of a table whose header is as it must be; those without enough columns are skipped.

    Each line is a row: a stray quote spoils no other.
    """
    name, columns = table
    path = folder / name
    header = _header(path)
    places = [header.index(column) for column in columns]
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        for number, line in enumerate(file, 1):
            cells = _cells(line)
            if number == 1 or not line.strip():
                continue
            if len(cells) > max(places):
                yield Row(f"{path}:{number}", tuple(cells[index] for index in places))
            else:
                faults.add("unparsable", f"{path}:{number}")


def range_reading(cells: tuple[str, ...], rangers: dict[str, Ranger]) -> RangeReading:
    """A row of ranges.csv. Raises RowFaultError."""
    stamp_ns = stamp(cells[0])
    value = _number(cells[2])
    ranger = rangers.get(cells[1])
    if ranger is None:
        raise RowFaultError("unknown sensor")
    outcome, distance = classified(value, ranger.nearest, ranger.farthest)
    return RangeReading(stamp_ns, 0, cells[1], outcome, distance, cells[2].encode())


def wheel_angles(cells: tuple[str, ...]) -> WheelAngles:
    """A row of wheels.csv, perhaps with the column `restarted`. Raises RowFaultError."""
    stamp_ns, (first, second) = stamp(cells[0]), _finite(cells[1:3])
    if cells[3:] not in ((), ("0",), ("1",)):
        raise RowFaultError("unparsable")
    return WheelAngles(stamp_ns, first, second, cells[3:] == ("1",))


def yaw_rate(cells: tuple[str, ...]) -> YawRate:
    """A row of gyro.csv. Raises RowFaultError."""
    (rate,) = _finite(cells[1:])
    return YawRate(stamp(cells[0]), rate)


def pose(cells: tuple[str, ...]) -> tuple[int, Pose]:
    """A row of poses.csv. Raises RowFaultError."""
    return stamp(cells[0]), Pose(*_finite(cells[1:]))


def stamp(text: str) -> int:
    """Seconds as written, in ns, exactly. Raises RowFaultError."""
    try:
        value = Decimal(text)
    except InvalidOperation:
        raise RowFaultError("unparsable") from None
    if not value.is_finite():
        raise RowFaultError("non-finite stamp")
    if not -_FARTHEST_STAMP_S <= value <= _FARTHEST_STAMP_S:
        raise RowFaultError("stamp out of range")
    return int((value * 1_000_000_000).to_integral_value())


def range_text(reading: RangeReading) -> str:
    """The range as REP-117 has it, with all its digits."""
    special = {Outcome.NO_ECHO: inf, Outcome.TOO_CLOSE: -inf, Outcome.INVALID: nan}
    return repr(special.get(reading.outcome, reading.distance))


def classified(value: float, nearest: float, farthest: float) -> tuple[Outcome, float]:
    """The outcome and distance of a range as REP-117 has it. Raises RowFaultError."""
    if isnan(value):
        return Outcome.INVALID, nan
    if -inf < value < 0.0:
        raise RowFaultError("negative range")
    return classify(value, nearest, farthest)


def _finite(texts: tuple[str, ...]) -> list[float]:
    values = [_number(text) for text in texts]
    if not all(isfinite(value) for value in values):
        raise RowFaultError("non-finite value")
    if not all(-_LARGEST <= value <= _LARGEST for value in values):
        raise RowFaultError("value out of range")
    return values


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise RowFaultError("unparsable") from None
    if isinf(value) and "inf" not in text.lower():  # 1e999 is not what a log writes for "no echo".
        raise RowFaultError("unparsable")
    return value


def _header(path: Path) -> list[str]:
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        return _cells(file.readline())


def _cells(line: str) -> list[str]:
    """The cells of a line; none if it is not CSV."""
    try:
        return [cell.strip() for cell in next(csv.reader([line]), [])]
    except csv.Error:
        return []
