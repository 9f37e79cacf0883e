from math import pi
from pathlib import Path

import pytest

from echogrid.drivers.readings import Outcome
from echogrid.runtime import offline, robond
from echogrid.runtime.errors import UsageError


def write(folder: Path, measurements: str, poses: str) -> Path:
    (folder / "measurement.txt").write_text(measurements)
    (folder / "poses.txt").write_text(poses)
    return folder


POSES = "".join(f"{t} {t} 0 900\n" for t in range(0, 1000, 100))
ROW = "2320 2360 5000 4999 0 5110 2160 1190"


def test_units_are_turned_into_si_and_each_row_is_eight_readings(tmp_path: Path) -> None:
    told = robond.read(write(tmp_path, f"100 {ROW}\n", POSES))
    stamp_ns, pose = told.poses[1]
    assert (stamp_ns, pose.x, pose.y, pose.yaw) == (
        100_000_000,
        pytest.approx(0.1),
        0.0,
        pytest.approx(pi / 2),
    )
    readings = [reading for _, reading in told.ranges]
    assert [reading.sensor for reading in readings] == [f"sonar{index}" for index in range(8)]
    assert readings[0].distance == pytest.approx(2.32)
    assert [r.outcome for r in readings[2:6]] == [
        Outcome.NO_ECHO,
        Outcome.ECHO,
        Outcome.ECHO,
        Outcome.NO_ECHO,
    ]


def test_the_sonars_look_where_the_recording_s_robot_has_them() -> None:
    yaws = [sensor.yaw_deg for sensor in robond.configuration().sensor]
    assert yaws == [-90.0, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90.0]


@pytest.mark.parametrize(
    ("row", "fault"),
    [
        ("soon " + ROW, "unparsable"),
        ("100 1 2 3", "unparsable"),
        ("100 -5 " + ROW[5:], "negative range"),
        ("100 " + "9" * 400 + ROW[4:], "unparsable"),
        ("9" * 5000 + " " + ROW, "unparsable"),
        ("\x00\x01", "unparsable"),
    ],
)
def test_a_bad_row_is_skipped_and_told(tmp_path: Path, row: str, fault: str) -> None:
    told = robond.read(write(tmp_path, f"{row}\n\n100 {ROW}\n", POSES))
    assert len(told.ranges) == 8
    assert told.faults.lines() == [f"{tmp_path}/measurement.txt:1: {fault}: 1 row skipped from here on"]
    assert offline.build(told).ledger.balances(0)


def test_poses_out_of_order_are_skipped_and_told(tmp_path: Path) -> None:
    told = robond.read(write(tmp_path, f"100 {ROW}\n", POSES.replace("100 100", "999999999 100", 1)))
    assert told.faults.lines() == [f"{tmp_path}/poses.txt:2: pose not monotonic: 1 row skipped from here on"]


def test_missing_files_are_told_at_once(tmp_path: Path) -> None:
    with pytest.raises(UsageError) as caught:
        robond.read(tmp_path)
    assert len(caught.value.problems) == 2
