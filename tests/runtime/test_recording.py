from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.runtime import recording
from echogrid.runtime.errors import UsageError
from echogrid.runtime.recording import monotonic
from echogrid.runtime.simple_log import RowFaults

from . import recordings

STAMPS = st.lists(st.integers(0, 12), max_size=9)


def kept(stamps: list[int]) -> tuple[list[int], list[str]]:
    """The rows' indices that stay, and the lines that are told of the others."""
    faults = RowFaults()
    entries = [(f"f:{index}", stamp, index) for index, stamp in enumerate(stamps)]
    pairs = monotonic(entries, faults)
    assert [stamps[index] for _, index in pairs] == [stamp for stamp, _ in pairs]
    return [index for _, index in pairs], faults.lines()


def longest_rise(stamps: list[int]) -> int:
    """By trying every subset."""
    best = 0
    for chosen in range(1 << len(stamps)):
        some = [stamp for index, stamp in enumerate(stamps) if chosen >> index & 1]
        if some == sorted(set(some)):
            best = max(best, len(some))
    return best


@given(STAMPS)
def test_what_stays_rises_and_no_more_is_skipped_than_must_be(stamps: list[int]) -> None:
    indices, _ = kept(stamps)
    some = [stamps[index] for index in indices]
    assert some == sorted(set(some))
    assert len(some) == longest_rise(stamps)


@pytest.mark.parametrize(
    ("stamps", "indices"),
    [
        ([0, 1, 2, 3], [0, 1, 2, 3]),
        ([0, 2, 1, 3], [0, 1, 3]),
        ([0, 1, 1, 2], [0, 1, 3]),
        ([0, 1, 99, 2, 3], [0, 1, 3, 4]),
        ([99, 0, 1, 2], [1, 2, 3]),
        ([5, 6, 7, 0, 1, 8], [0, 1, 2, 5]),
        ([], []),
    ],
)
def test_the_row_that_is_out_of_order_is_the_one_that_is_skipped(
    stamps: list[int], indices: list[int]
) -> None:
    assert kept(stamps)[0] == indices


def test_skipped_rows_are_told_in_one_line_with_the_first_one_s_place() -> None:
    assert kept([0, 5, 1, 2, 3])[1] == ["f:1: pose not monotonic: 1 row skipped from here on"]
    assert kept([0, 5, 6, 1, 7, 2])[1] == ["f:3: pose not monotonic: 2 rows skipped from here on"]


def test_a_recording_is_read_with_each_reading_s_place(tmp_path: Path) -> None:
    told = recording.read_simple(recordings.write(tmp_path))
    assert len(told.poses) == 101
    assert len(told.ranges) == 200
    assert told.ranges[3][0] == f"{tmp_path}/ranges.csv:5"
    assert told.faults.counts == {}


def test_wheels_are_reckoned_into_poses_by_the_robot_s_measures(tmp_path: Path) -> None:
    rows = [f"{step},{step},{step}" for step in range(5)] + ["5,4,10.0"]
    told = recording.read_simple(recordings.write(tmp_path, wheels=rows))
    stamp_ns, straight = told.poses[4]
    assert (stamp_ns, straight.x, straight.y) == (4_000_000_000, pytest.approx(0.2), 0.0)
    assert told.poses[5][1].yaw == pytest.approx(6.0 * 0.05 / 0.3)


def test_poses_are_preferred_to_wheels(tmp_path: Path) -> None:
    recordings.write(tmp_path, wheels=["0,0,0"])
    recordings.write(tmp_path)
    assert len(recording.read_simple(tmp_path).poses) == 101


def test_a_wheel_row_far_in_the_future_costs_itself_only(tmp_path: Path) -> None:
    rows = [f"{step},{step},{step}" for step in range(5)]
    told = recording.read_simple(recordings.write(tmp_path, wheels=[*rows[:2], "3999999999,9,9", *rows[2:]]))
    assert [stamp_ns // 10**9 for stamp_ns, _ in told.poses] == [0, 1, 2, 3, 4]
    assert told.poses[-1][1].x == pytest.approx(0.2)
    assert told.faults.lines() == [f"{tmp_path}/wheels.csv:4: pose not monotonic: 1 row skipped from here on"]


def test_all_that_keeps_a_recording_from_being_read_is_told_at_once(tmp_path: Path) -> None:
    (tmp_path / "robot.toml").write_text(recordings.ROBOT.replace("max_m", "maxm"))
    (tmp_path / "poses.csv").write_text("stamp,x_m,y_m\n")
    with pytest.raises(UsageError) as caught:
        recording.read_simple(tmp_path)
    told = "\n".join(caught.value.problems)
    for part in (
        "missing key `max_m`",
        "unknown key `maxm`",
        "ranges.csv: no such file",
        "lacks stamp_s, yaw_rad",
    ):
        assert part in told


def test_wheels_without_the_robot_s_measures_are_told(tmp_path: Path) -> None:
    robot = recordings.ROBOT.replace("track_m = 0.3\n", "")
    with pytest.raises(UsageError, match="`wheel_radius_m` and `track_m` are needed"):
        recording.read_simple(recordings.write(tmp_path, robot=robot, wheels=["0,0,0"]))
