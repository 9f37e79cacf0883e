"""Emulated robots whose wheels are not as configured, calibrated through the command line."""

import shutil
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from echogrid.emulation.motion import Tour
from echogrid.runtime import robot_file
from echogrid.runtime.command_line import main
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.hardware_config import RobotConfig
from echogrid.runtime.log_writer import LogWriter
from echogrid.runtime.odometry_check import drive, square

ROBOT = DEFAULT_ROBOT.read_text()
CONFIG = robot_file.load(DEFAULT_ROBOT)
BODY = replace(CONFIG.robot, wheel_radius_m=0.0606, wheel_ratio=1.004, track_m=0.3136)


def record(folder: Path, tour: Tour, body: RobotConfig = BODY) -> None:
    with LogWriter(folder, ROBOT) as log:
        drive(CONFIG, tour, body, log)


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A square in each direction, there and back again straight on, and the robot's description."""
    folder = tmp_path_factory.mktemp("logs")
    record(folder / "cw", square(2.0, -1))
    record(folder / "ccw", square(2.0, 1))
    record(folder / "back", Tour(((0.0, 0.0), (1.0, 0.0)), wait=1.0))
    rows = (folder / "cw" / "wheels.csv").read_text().splitlines(keepends=True)
    shutil.copytree(folder / "cw", folder / "straight")
    first_side_s = 1.0 + 2.0 / 0.4 + 0.4 / 0.5
    stopped = [row for row in rows[1:] if float(row.split(",")[0]) <= 1.0 + first_side_s]
    (folder / "straight" / "wheels.csv").write_text("".join([rows[0], *stopped]))
    return folder


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    path = tmp_path / "robot.toml"
    path.write_text(ROBOT)
    return path


def told(capsys: pytest.CaptureFixture[str], *arguments: Any) -> tuple[int, str, str]:
    code = main(["calibrate", "odometry", *map(str, arguments)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_a_straight_run_and_squares_tell_the_true_measures_and_write_them(
    capsys: pytest.CaptureFixture[str], logs: Path, robot: Path, tmp_path: Path
) -> None:
    code, said, _ = told(capsys, logs / "straight", "--straight", 2, "--write", robot)
    assert (code, said.splitlines()[-1]) == (0, f"{robot}: wheel_radius_m changed")
    for name in ("cw", "ccw"):
        shutil.copytree(logs / name, tmp_path / name)
        shutil.copy(robot, tmp_path / name / "robot.toml")
    code, said, _ = told(capsys, tmp_path / "cw", tmp_path / "ccw", "--square", "--write", robot)
    assert (code, said.splitlines()[-1]) == (0, f"{robot}: wheel_ratio, track_m changed")
    found = robot_file.load(robot).robot
    assert found.wheel_radius_m == pytest.approx(0.0606, rel=1e-3)
    assert found.wheel_ratio == pytest.approx(1.004, abs=1e-4)
    assert found.track_m == pytest.approx(0.3136, rel=1e-3)
    assert tomllib.loads(robot.read_text()) == tomllib.loads(ROBOT) | {
        "robot": tomllib.loads(robot.read_text())["robot"]
    }


def test_it_tells_the_old_and_new_measures_and_the_error_to_expect(
    capsys: pytest.CaptureFixture[str], logs: Path
) -> None:
    code, said, errors = told(capsys, logs / "cw", logs / "ccw", "--square")
    lines = [line.split() for line in said.splitlines()]
    assert (code, errors) == (0, "")
    assert lines[0] == ["old", "new"]
    assert [line[:2] for line in lines[1:4]] == [
        ["wheel_radius_m", "0.06"],
        ["wheel_ratio", "1"],
        ["track_m", "0.32"],
    ]
    old, new = (float(lines[4][index]) for index in (9, 12))
    assert old > 0.1
    assert new < old / 100.0
    assert said.splitlines()[-2:] == [
        "with one run a direction nobody knows what of this was chance: drive more",
        "nothing was written (--write robot.toml does it)",
    ]


def test_two_runs_in_each_direction_show_the_scatter(
    capsys: pytest.CaptureFixture[str], logs: Path, tmp_path: Path
) -> None:
    twins = [tmp_path / name for name in ("cw", "ccw")]
    for twin in twins:
        shutil.copytree(logs / twin.name, twin)
    runs = [*twins, logs / "cw", logs / "ccw"]
    ends = ["--end", twins[0], "0.02", "0", "--end", twins[1], "0.02", "0"]
    _, said, _ = told(capsys, *runs, "--square", *ends)
    assert "single runs scatter around their mean by 0.0100 m (rms)" in said


def test_a_skid_steered_robot_s_slip_factor_is_found_and_its_track_left_alone(
    capsys: pytest.CaptureFixture[str], logs: Path, tmp_path: Path
) -> None:
    for name in ("cw", "ccw"):
        shutil.copytree(logs / name, tmp_path / name)
        path = tmp_path / name / "robot.toml"
        path.write_text(ROBOT.replace("track_m = 0.32", "track_m = 0.2\nslip_factor = 1.6"))
    told(capsys, tmp_path / "cw", tmp_path / "ccw", "--square", "--write", tmp_path / "cw" / "robot.toml")
    found = robot_file.load(tmp_path / "cw" / "robot.toml").robot
    assert found.track_m == 0.2
    assert found.slip_factor == pytest.approx(0.3136 / 0.2 / 1.01, rel=1e-3)


def test_ends_beside_the_start_change_what_is_found(capsys: pytest.CaptureFixture[str], logs: Path) -> None:
    plain = told(capsys, logs / "cw", logs / "ccw", "--square")[1]
    moved = told(capsys, logs / "cw", logs / "ccw", "--square", "--end", logs / "cw", "-0.1", "0.05")[1]
    assert plain != moved


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["cw", "--square"], "squares in both directions are needed"),
        (["cw", "straight", "--square"], "straight: no square: it went 1.98 m and turned"),
        (["cw", "gone", "--square"], "gone/wheels.csv: no such file"),
        (["cw", "ccw", "--square", "--end", "cw", "left", "0"], "X and Y are metres"),
        (["cw", "ccw", "--square", "--end", "none", "0", "0"], "an end is given, but it is no LOG"),
        (["back", "--straight", "3000"], "`wheel_radius_m` must lie in 0.001...100"),
    ],
)
def test_what_makes_no_calibration_is_told(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    logs: Path,
    arguments: list[str],
    problem: str,
) -> None:
    monkeypatch.chdir(logs)
    code, said, errors = told(capsys, *arguments)
    assert (code, said) == (2, "")
    assert problem in errors


def test_logs_of_different_robots_are_not_mixed(
    capsys: pytest.CaptureFixture[str], logs: Path, tmp_path: Path
) -> None:
    other = tmp_path / "other"
    shutil.copytree(logs / "ccw", other)
    (other / "robot.toml").write_text(ROBOT.replace("track_m = 0.32", "track_m = 0.33"))
    code, _, errors = told(capsys, logs / "cw", other, "--square")
    assert code == 2
    assert errors == f"{other}/robot.toml: other measures than {logs}/cw/robot.toml has\n"


def test_a_robot_toml_that_can_not_be_edited_is_left_alone_and_told_what_to_write(
    capsys: pytest.CaptureFixture[str], logs: Path, tmp_path: Path
) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(f"robot.track_m = 0.32\nrobot.wheel_radius_m = 0.06\n{ROBOT[ROBOT.index('[loop]') :]}")
    before = path.read_text()
    code, _, errors = told(capsys, logs / "cw", logs / "ccw", "--square", "--write", path)
    assert code == 2
    assert "write it yourself: wheel_ratio = 1.00" in errors
    assert path.read_text() == before


def test_rows_that_can_not_be_used_are_counted(
    capsys: pytest.CaptureFixture[str], logs: Path, tmp_path: Path
) -> None:
    log = tmp_path / "cw"
    shutil.copytree(logs / "cw", log)
    with (log / "wheels.csv").open("a") as file:
        file.write("x,1,2\n")
    code, _, errors = told(capsys, log, logs / "ccw", "--square")
    assert code == 0
    assert "unparsable: 1 row skipped" in errors
