from itertools import pairwise
from math import hypot
from pathlib import Path

import pytest

from echogrid.mapping.pose import Pose
from echogrid.runtime import evaluation, offline, robot_file
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.evaluation import (
    Tape,
    half_wheels,
    late,
    mirrored,
    office_cases,
    office_table,
    recorded,
)
from echogrid.runtime.recording import Recording

MS = 1_000_000


@pytest.fixture(scope="module")
def tape() -> Tape:
    return evaluation.drive_tour(evaluation.default_config(), 1, 2.0)


def way(told: Recording) -> float:
    return sum(hypot(b.x - a.x, b.y - a.y) for (_, a), (_, b) in pairwise(told.poses))


def test_late_poses_are_those_of_100_ms_before() -> None:
    poses = [(step * 20 * MS, Pose(float(step))) for step in range(20)]
    assert [pose.x for _, pose in late(poses)] == [max(step - 5.0, 0.0) for step in range(20)]
    assert [stamp_ns for stamp_ns, _ in late(poses)] == [stamp_ns for stamp_ns, _ in poses]


def test_mirroring_twice_changes_nothing() -> None:
    config = robot_file.load(DEFAULT_ROBOT)
    assert mirrored(config) != config
    assert mirrored(mirrored(config)) == config


def test_half_wheels_drive_half_the_way(tape: Tape) -> None:
    config = evaluation.default_config()
    ways = [way(recorded(each, tape)) for each in (config, half_wheels(config))]
    assert ways[0] == pytest.approx(2 * ways[1], rel=1e-3)


def test_each_case_spoils_the_same_tape_in_one_way(tape: Tape) -> None:
    config = evaluation.default_config()
    cases = dict(office_cases(config, tape))
    assert list(cases) == [
        "as it is",
        "sensor order mirrored",
        "wheels of half the size",
        "poses 100 ms late",
    ]
    images = [offline.build(each).image.occupancy.tobytes() for each in cases.values()]
    assert len(set(images)) == 4


def test_the_table_has_a_row_for_each_case(monkeypatch: pytest.MonkeyPatch, tape: Tape) -> None:
    monkeypatch.setattr(evaluation, "drive_tour", lambda config, seed, metres: tape)
    rows = list(office_table(1, 2.0))
    assert rows[0].startswith(f"| office, 2 m, {len(tape.ranges)} pings")
    assert len(rows) == 6
    assert {row.count("|") for row in rows} == {6}


def test_the_recording_s_table_tells_right_from_mirrored(tmp_path: Path) -> None:
    """A corridor 2.4 m wide, driven along its middle."""
    times = range(0, 60_000, 200)
    side = "1200 5000 5000 5000 5000 5000 5000 1200"
    (tmp_path / "measurement.txt").write_text("".join(f"{t} {side}\n" for t in times))
    (tmp_path / "poses.txt").write_text("".join(f"{t} {t // 20} {0} 0\n" for t in times))
    rows = list(evaluation.robond_table(tmp_path))
    assert len(rows) == 4
    drawn = float(rows[2].split("|")[3].strip(" %"))
    assert drawn > 90.0
