"""The simple log: a folder with robot.toml, ranges.csv and wheels.csv or poses.csv."""

import csv
from collections.abc import Iterator
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from math import inf, isfinite, isnan, nan
from pathlib import Path
from typing import Any

from echogrid.drivers.readings import Outcome, RangeReading, classify
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime.errors import UsageError

RANGES = "ranges.csv", ("stamp_s", "sensor", "range_m")
WHEELS = "wheels.csv", ("stamp_s", "left_rad", "right_rad")
POSES = "poses.csv", ("stamp_s", "x_m", "y_m", "yaw_rad")

_FARTHEST_STAMP_S = 10**11
"""Beyond that a stamp is nonsense."""


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


def missing(folder: Path) -> list[str]:
    """What a log folder lacks, one line each."""
    names = [RANGES[0]]
    problems = [f"{folder / name}: no such file" for name in names if not (folder / name).is_file()]
    if not any((folder / name).is_file() for name in (WHEELS[0], POSES[0])):
        problems.append(f"{folder}: neither {POSES[0]} nor {WHEELS[0]}: one of them says where the robot was")
    return problems


def rows(folder: Path, table: tuple[str, tuple[str, ...]], faults: RowFaults) -> Iterator[Row]:
    """The rows of a table, those without enough columns skipped. Raises UsageError on a wrong header."""
    name, columns = table
    path = folder / name
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        reader = csv.reader(file)
        places = _columns(path, next(_cells(reader, path, faults), []), columns)
        for cells in _cells(reader, path, faults):
            place = f"{path}:{reader.line_num}"
            if len(cells) <= max(places):
                if cells:
                    faults.add("unparsable", place)
                continue
            yield Row(place, tuple(cells[index].strip() for index in places))


def range_reading(cells: tuple[str, ...], rangers: dict[str, Ranger]) -> RangeReading:
    """A row of ranges.csv. Raises RowFaultError."""
    stamp_ns = stamp(cells[0])
    value = _number(cells[2])
    ranger = rangers.get(cells[1])
    if ranger is None:
        raise RowFaultError("unknown sensor")
    outcome, distance = _outcome(value, ranger)
    return RangeReading(stamp_ns, 0, cells[1], outcome, distance, cells[2].encode())


def wheel_angles(cells: tuple[str, ...]) -> WheelAngles:
    """A row of wheels.csv. Raises RowFaultError."""
    return WheelAngles(stamp(cells[0]), *_finite(cells[1:]))


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
    if abs(value) > _FARTHEST_STAMP_S:
        raise RowFaultError("stamp out of range")
    return int((value * 1_000_000_000).to_integral_value())


def range_text(reading: RangeReading) -> str:
    """The range as REP-117 has it, with all its digits."""
    special = {Outcome.NO_ECHO: inf, Outcome.TOO_CLOSE: -inf, Outcome.INVALID: nan}
    return repr(special.get(reading.outcome, reading.distance))


def _outcome(value: float, ranger: Ranger) -> tuple[Outcome, float]:
    if isnan(value):
        return Outcome.INVALID, nan
    if -inf < value < 0.0:
        raise RowFaultError("negative range")
    return classify(value, ranger.nearest, ranger.farthest)


def _finite(texts: tuple[str, ...]) -> list[float]:
    values = [_number(text) for text in texts]
    if not all(isfinite(value) for value in values):
        raise RowFaultError("non-finite value")
    return values


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise RowFaultError("unparsable") from None


def _cells(reader: Any, path: Path, faults: RowFaults) -> Iterator[list[str]]:
    while True:
        try:
            yield next(reader)
        except StopIteration:
            return
        except csv.Error:
            faults.add("unparsable", f"{path}:{reader.line_num}")


def _columns(path: Path, header: list[str], wanted: tuple[str, ...]) -> list[int]:
    names = [name.strip() for name in header]
    absent = [name for name in wanted if name not in names]
    if absent:
        raise UsageError([f"{path}:1: the header lacks {', '.join(absent)}: it must be {','.join(wanted)}"])
    return [names.index(name) for name in wanted]
