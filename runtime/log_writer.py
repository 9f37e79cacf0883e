"""Writing a simple log beside a run: its own thread, so that a slow disk never holds the loop up."""

import queue
import threading
from collections.abc import Iterable
from pathlib import Path
from typing import Self

from echogrid.drivers.readings import RangeReading
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime.map_files import seconds
from echogrid.runtime.simple_log import RANGES, WHEELS, range_text

_MOST_PORTIONS = 10_000
_STOP_S = 30.0

Portion = tuple[tuple[RangeReading, ...], tuple[WheelAngles, ...]]


class LogWriter:
    """Writes robot.toml at once, then ranges.csv and wheels.csv as they come. Leave it to finish the files.

    Raises OSError when the folder can't be written; later trouble is kept in `trouble`, and what could
    not be written is counted in `lost`.
    """

    def __init__(self, folder: Path, robot_toml: str) -> None:
        self.lost = 0
        self.trouble = ""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "robot.toml").write_text(robot_toml, encoding="utf-8")
        self._ranges = (folder / RANGES[0]).open("w", encoding="utf-8")
        self._wheels = (folder / WHEELS[0]).open("w", encoding="utf-8")
        self._ranges.write(",".join(RANGES[1]) + "\n")
        self._wheels.write(",".join(WHEELS[1]) + "\n")
        self._portions: queue.Queue[Portion | None] = queue.Queue(_MOST_PORTIONS)
        self._thread = threading.Thread(target=self._run, name="log", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._portions.put(None, timeout=_STOP_S)
        self._thread.join(_STOP_S)

    def put(self, ranges: tuple[RangeReading, ...], wheels: tuple[WheelAngles, ...]) -> None:
        """Hand over what a tick took in; never waits."""
        try:
            self._portions.put_nowait((ranges, wheels))
        except queue.Full:
            self.lost += len(ranges) + len(wheels)

    def _run(self) -> None:
        with self._ranges, self._wheels:
            while (portion := self._portions.get()) is not None:
                try:
                    self._ranges.writelines(_range_rows(portion[0]))
                    self._wheels.writelines(_wheel_rows(portion[1]))
                except OSError as error:
                    self.trouble = f"{error.filename or 'log'}: {error.strerror}"
                    self.lost += len(portion[0]) + len(portion[1])


def _range_rows(readings: Iterable[RangeReading]) -> list[str]:
    return [f"{seconds(each.stamp_ns)},{each.sensor},{range_text(each)}\n" for each in readings]


def _wheel_rows(pairs: Iterable[WheelAngles]) -> list[str]:
    return [f"{seconds(each.stamp_ns)},{each.left!r},{each.right!r}\n" for each in pairs]
