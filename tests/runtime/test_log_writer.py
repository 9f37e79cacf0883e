import resource
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from echogrid.drivers.readings import Outcome
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime import log_writer, recording
from echogrid.runtime.errors import UsageError
from echogrid.runtime.log_writer import LogWriter

from . import recordings
from .fakes import echo, told

PAIR = WheelAngles(3, 0.1, -2.0)


def test_what_is_put_in_is_read_back_to_the_last_digit(tmp_path: Path) -> None:
    ranges = (echo(1_000_000_001, 0.1 + 0.2, "front"), told(1_500_000_000, Outcome.NO_ECHO, "left"))
    pairs = tuple(WheelAngles(k * 500_000_000, 0.1 * k, 1 / 3 * k, k == 3) for k in range(5))
    with LogWriter(tmp_path, recordings.ROBOT) as log:
        log.put(ranges, pairs[:2])
        log.put((), pairs[2:])
    read = recording.read_simple(tmp_path)
    assert [(r.stamp_ns, r.sensor, r.outcome) for _, r in read.ranges] == [
        (r.stamp_ns, r.sensor, r.outcome) for r in ranges
    ]
    assert read.ranges[0][1].distance == 0.1 + 0.2
    rows = (tmp_path / "wheels.csv").read_text().splitlines()[1:]
    assert [tuple(map(float, row.split(","))) for row in rows] == [
        (p.stamp_ns / 1e9, p.first, p.second, p.restarted) for p in pairs
    ]
    assert (log.lost, log.trouble, read.faults.counts) == (0, "", {})


def test_a_sensor_s_name_may_hold_what_csv_must_quote(tmp_path: Path) -> None:
    robot = recordings.ROBOT.replace('name = "front"', "name = 'fr\"o,nt'")
    with LogWriter(tmp_path, robot) as log:
        log.put((echo(0, 1.0, 'fr"o,nt'),), (PAIR,))
    read = recording.read_simple(tmp_path)
    assert [reading.sensor for _, reading in read.ranges] == ['fr"o,nt']


def test_rows_are_in_the_file_as_soon_as_the_writer_has_come_to_them(tmp_path: Path) -> None:
    with LogWriter(tmp_path, "") as log:
        log.put((echo(0),), ())
        while not (tmp_path / "ranges.csv").read_text().endswith("0.000000000,front,1.0\n"):
            assert log.lost == 0


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """Of the whole process, as on a disk that is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize(("ranges", "pairs", "lost"), [(1, 0, 3), (0, 1, 3), (2, 1, 12)])
def test_a_disk_that_gets_full_is_told_and_every_missing_row_counted(
    tmp_path: Path, ranges: int, pairs: int, lost: int
) -> None:
    with largest_file(60), LogWriter(tmp_path, "") as log:
        for _ in range(4):
            log.put((echo(0),) * ranges, (PAIR,) * pairs)
    assert log.trouble == "File too large"
    assert log.lost == lost


def test_a_disk_that_is_full_from_the_start_is_an_error_at_once(tmp_path: Path) -> None:
    (tmp_path / "ranges.csv").symlink_to("/dev/full")
    with pytest.raises(OSError, match="No space left"):
        LogWriter(tmp_path, "")


def test_when_the_writer_cannot_keep_up_the_loop_does_not_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log_writer, "_MOST_PORTIONS", 2)
    log = LogWriter(tmp_path, "")
    for _ in range(5):
        log.put((echo(0),), (PAIR,))
    with log:
        pass
    assert log.lost == 6
    assert log.trouble == "the disk is too slow"


@pytest.mark.parametrize("name", ["robot.toml", "ranges.csv", "wheels.csv", "poses.csv"])
def test_a_recording_that_is_there_already_is_left_alone(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("precious")
    with pytest.raises(UsageError, match=f"{name}: is there already"):
        LogWriter(tmp_path, "")
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "precious"


def test_its_thread_ends_with_the_context(tmp_path: Path) -> None:
    before = threading.active_count()
    with LogWriter(tmp_path, ""):
        assert threading.active_count() == before + 1
    assert threading.active_count() == before
