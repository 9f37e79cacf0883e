"""Writing a simple log beside a run: its own thread, so that a slow disk never holds the loop up."""

import contextlib
import csv
import queue
import threading
from collections.abc import Iterable
from io import FileIO, StringIO
from pathlib import Path
from typing import Self

from echogrid.drivers.readings import RangeReading
from echogrid.mapping.kinematics import Differential, Wheels
from echogrid.mapping.reckoning import YawRate
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime.errors import UsageError
from echogrid.runtime.map_files import seconds
from echogrid.runtime.simple_log import GYRO, POSES, RANGES, RESTARTED, WHEELS, Table, range_text, wheel_table

_MOST_PORTIONS = 10_000
_STOP_S = 30.0

Portion = tuple[tuple[RangeReading, ...], tuple[WheelAngles, ...], tuple[YawRate, ...]]
Row = tuple[str, ...]


class LogWriter:
    """Writes robot.toml at once, then ranges.csv, wheels.csv and, with a gyro, gyro.csv as they come. Leave
    it to finish the files.

    Raises OSError when the folder can't be written, UsageError when it holds a recording already. After the
    first row that can't be written no other is, and all of them are counted.
    """

    def __init__(
        self,
        folder: Path,
        robot_toml: str,
        with_gyro: bool = False,
        wheels: Wheels = Differential.wheels,
    ) -> None:
        self._fault = ""
        self._unwritten = 0
        self._refused = 0
        folder.mkdir(parents=True, exist_ok=True)
        for name in ("robot.toml", RANGES[0], WHEELS, GYRO[0], POSES[0]):
            if (folder / name).is_file():
                raise UsageError([f"{folder / name}: is there already: choose another folder for the log"])
        (folder / "robot.toml").write_text(robot_toml, encoding="utf-8")
        with contextlib.ExitStack() as stack:
            self._ranges = _begun(folder, RANGES, stack)
            self._wheels = _begun(folder, wheel_table(wheels, (RESTARTED,)), stack)
            self._rates = _begun(folder, GYRO, stack) if with_gyro else None
            self._files = stack.pop_all()
        self._portions: queue.Queue[Portion | None] = queue.Queue(_MOST_PORTIONS)
        self._thread = threading.Thread(target=self._run, name="log", daemon=True)

    @property
    def lost(self) -> int:
        """How many rows are missing."""
        return self._unwritten + self._refused

    @property
    def trouble(self) -> str:
        """Why they are; empty if none is."""
        return self._fault or ("the disk is too slow" if self._refused else "")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(queue.Full):
            self._portions.put(None, timeout=_STOP_S)
        self._thread.join(_STOP_S)

    def put(
        self,
        ranges: tuple[RangeReading, ...],
        wheels: tuple[WheelAngles, ...],
        rates: tuple[YawRate, ...] = (),
    ) -> None:
        """Hand over what a tick took in; never waits."""
        if not self._refused:
            with contextlib.suppress(queue.Full):
                self._portions.put_nowait((ranges, wheels, rates))
                return
        self._refused += len(ranges) + len(wheels) + len(rates)

    def _run(self) -> None:
        with self._files:
            while (portion := self._portions.get()) is not None:
                ranges, wheels, rates = portion
                if not self._written(self._ranges, map(_range_row, ranges)):
                    self._unwritten += len(ranges)
                if not self._written(self._wheels, map(_wheel_row, wheels)):
                    self._unwritten += len(wheels)
                if self._rates is not None and not self._written(self._rates, map(_rate_row, rates)):
                    self._unwritten += len(rates)

    def _written(self, file: FileIO, rows: Iterable[Row]) -> bool:
        if self._fault:
            return False
        data = _lines(rows)
        try:
            while data:
                data = data[file.write(data) :]
        except OSError as error:
            self._fault = error.strerror or str(error)
        return not self._fault


def _begun(folder: Path, table: Table, stack: contextlib.ExitStack) -> FileIO:
    """The table's new file, with its header; it is closed with the stack."""
    name, columns = table
    file = stack.enter_context((folder / name).open("wb", buffering=0))
    file.write(_lines([columns]))
    return file


def _lines(rows: Iterable[Iterable[str]]) -> bytes:
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()


def _range_row(reading: RangeReading) -> Row:
    return seconds(reading.stamp_ns), reading.sensor, range_text(reading)


def _wheel_row(angles: WheelAngles) -> Row:
    return seconds(angles.stamp_ns), repr(angles.first), repr(angles.second), str(int(angles.restarted))


def _rate_row(rate: YawRate) -> Row:
    return seconds(rate.stamp_ns), repr(rate.rate)
