"""echogrid calibrate sensor, through the command line."""

import json
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest

from echogrid.runtime import recording, reference_map, robot_file, sensor_calibration, sensor_writing
from echogrid.runtime.command_line import main
from echogrid.runtime.errors import UsageError
from echogrid.runtime.sensor_writing import Mended
from echogrid.runtime.simple_log import range_text

from . import sensor_logs
from .sensor_logs import Trick

MAP = "[map]\nresolution_m = 0.1\ntolerance_m = 0.03\n"


def robot_text(trick: Trick, half_angle_deg: float) -> str:
    """The robot.toml of such a log, with comments to be kept."""
    parts = ['[robot] # of the tests\nname = "r"\n', MAP]
    for sensor in sensor_logs.sensors(half_angle_deg):
        yaw = sensor.yaw_deg + trick.yaw_deg.get(sensor.name, 0.0)
        parts.append(
            f'[[sensor]]\nname = "{sensor.name}"\nx_m = {sensor.x_m}\ny_m = {sensor.y_m}\n'
            f"yaw_deg = {yaw} # by eye\nhalf_angle_deg = {half_angle_deg}\nmin_m = 0.05\nmax_m = 3.0\n"
        )
    return "\n".join(parts)


def write(folder: Path, seconds: float, trick: Trick, half_angle_deg: float = 15.0) -> Path:
    """The log in the simple format."""
    made = sensor_logs.log(seconds, trick, half_angle_deg)
    folder.mkdir(parents=True)
    (folder / "robot.toml").write_text(robot_text(trick, half_angle_deg))
    rows = [
        f"{reading.stamp_ns / 1e9:.9f},{reading.sensor},{range_text(reading)}" for _, reading in made.ranges
    ]
    (folder / "ranges.csv").write_text("\n".join(["stamp_s,sensor,range_m", *rows, ""]))
    poses = [f"{now / 1e9:.9f},{pose.x!r},{pose.y!r},{pose.yaw!r}" for now, pose in made.poses]
    (folder / "poses.csv").write_text("\n".join(["stamp_s,x_m,y_m,yaw_rad", *poses, ""]))
    return folder


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("logs") / "log", 200.0, Trick({"left": 4.0}), 45.0)


@pytest.fixture(scope="module")
def found(log: Path) -> Mended:
    """What a calibration by the log's own map would write."""
    told = recording.read_simple(log)
    pings = reference_map.placed(told)
    reference = reference_map.of_itself(told, pings)
    return sensor_writing.mended(told.config, sensor_calibration.results(told, pings, reference, 1))


def told(capsys: pytest.CaptureFixture[str], *arguments: Any) -> tuple[int, str, str]:
    code = main(["calibrate", "sensor", *map(str, arguments)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_the_card_is_told_and_what_is_better_is_written_with_the_model_beside_it(
    capsys: pytest.CaptureFixture[str], log: Path, found: Mended, tmp_path: Path
) -> None:
    robot = tmp_path / "robot.toml"
    shutil.copy(log / "robot.toml", robot)
    code, said, errors = told(capsys, log, "--write", robot)
    assert (code, errors) == (0, "")
    assert "rangers: front, left, rear, right" in said
    assert "walls answer within" in said
    assert "held-out skill +" in said
    assert f'{robot}: model = "empirical" (sonar_model.json)' in said
    written = {sensor.name: sensor for sensor in robot_file.load(robot).sensor}
    assert written["left"].yaw_deg == pytest.approx(90.0, abs=1.5)
    assert written["front"].yaw_deg == pytest.approx(0.0, abs=1.5)
    assert written["left"].half_angle_deg == pytest.approx(29.0, abs=3.0)
    assert written["left"].tolerance_m == pytest.approx(2.0 * (0.005 + 0.01 * 1.8), abs=0.02)
    models = json.loads((tmp_path / "sonar_model.json").read_text())["models"]
    assert [each["sensors"] for each in models] == [["front", "left", "rear", "right"]]
    assert (tmp_path / "sonar_model.json").read_text() == found.model  # The same log gives the same bytes.


def test_all_else_of_the_file_stays_and_the_log_is_mapped_by_it(
    log: Path, found: Mended, tmp_path: Path
) -> None:
    again = tmp_path / "again"
    shutil.copytree(log, again)
    sensor_writing.write(again / "robot.toml", found)
    before, after = (tomllib.loads((each / "robot.toml").read_text()) for each in (log, again))
    assert "# by eye" in (again / "robot.toml").read_text()
    for one, other in zip(before.pop("sensor"), after.pop("sensor"), strict=True):
        changed = {key for key in other if one.get(key) != other[key]}
        assert changed <= {"yaw_deg", "half_angle_deg", "tolerance_m"}
    assert after["map"].pop("model_file") == "sonar_model.json"
    assert after["map"].pop("model") == "empirical"
    assert after == before
    for theory in ("bayes", "dempster-shafer"):
        assert main(["map", str(again), "--out", str(tmp_path / theory), "--theory", theory]) == 0


def test_of_a_short_log_it_is_told_in_a_line_what_is_missing_and_nothing_is_written(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    short = write(tmp_path / "short", 5.0, Trick({"left": 4.0}))
    before = (short / "robot.toml").read_bytes()
    code, said, _ = told(capsys, short, "--write", short / "robot.toml")
    assert code == 0
    assert "  walls answer         not known: " in said
    assert "views of walls that answered, 100 are needed" in said
    assert said.splitlines()[-1] == f"{short}/robot.toml: nothing changed"
    assert (short / "robot.toml").read_bytes() == before
    assert not (short / "sonar_model.json").exists()


def test_without_write_nothing_is_written(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    short = write(tmp_path / "short", 5.0, Trick())
    before = sorted(short.iterdir())
    _, said, _ = told(capsys, short)
    assert said.splitlines()[-1] == "nothing was written (--write robot.toml does it)"
    assert sorted(short.iterdir()) == before


def test_a_truth_may_be_given_as_a_map(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    log = write(tmp_path / "log", 60.0, Trick())
    assert main(["map", str(log), "--out", str(tmp_path / "map")]) == 0
    code, said, _ = told(capsys, log, "--truth", tmp_path / "map/map.npz")
    assert code == 0
    assert "judged by the map that was given" in said


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["gone"], "gone: no such folder"),
        (["log", "--truth", "gone.yaml"], "gone.yaml: no such file"),
        (["log", "--truth", "emulated"], "it was not made by `echogrid run --simulate`"),
    ],
)
def test_what_makes_no_calibration_is_told(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    log: Path,
    arguments: list[str],
    problem: str,
) -> None:
    monkeypatch.chdir(log.parent)
    code, said, errors = told(capsys, *arguments)
    assert (code, said) == (2, "")
    assert problem in errors


def test_another_robot_s_file_is_left_alone(log: Path, found: Mended, tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text((log / "robot.toml").read_text().replace('"left"', '"port"'))
    before = robot.read_bytes()
    with pytest.raises(UsageError, match=r"no .*sensor.* named 'left': is it another robot"):
        sensor_writing.write(robot, found)
    assert robot.read_bytes() == before
    assert not (tmp_path / "sonar_model.json").exists()


def test_a_file_without_a_table_for_the_model_is_left_alone_and_told_what_to_write(
    log: Path, found: Mended, tmp_path: Path
) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text((log / "robot.toml").read_text().replace(MAP, ""))
    before = robot.read_bytes()
    with pytest.raises(UsageError) as raised:
        sensor_writing.write(robot, found)
    assert "[map] is not written one key a line: write it yourself: front: " in str(raised.value)
    assert 'model_file = "sonar_model.json"' in str(raised.value)
    assert robot.read_bytes() == before
    assert not (tmp_path / "sonar_model.json").exists()


def test_a_log_that_was_made_with_a_model_can_be_calibrated_again(
    capsys: pytest.CaptureFixture[str], found: Mended, tmp_path: Path
) -> None:
    log = write(tmp_path / "log", 60.0, Trick(), 45.0)
    sensor_writing.write(log / "robot.toml", found)
    code, said, _ = told(capsys, log)
    assert code == 0
    assert "held-out skill" in said


def test_a_file_that_is_a_link_stays_one_and_the_model_lies_beside_what_it_leads_to(
    log: Path, found: Mended, tmp_path: Path
) -> None:
    (tmp_path / "true").mkdir()
    shutil.copy(log / "robot.toml", tmp_path / "true")
    (tmp_path / "robot.toml").symlink_to(tmp_path / "true/robot.toml")
    sensor_writing.write(tmp_path / "robot.toml", found)
    assert (tmp_path / "robot.toml").is_symlink()
    assert (tmp_path / "true/sonar_model.json").is_file()
    assert robot_file.load(tmp_path / "robot.toml").map.model == "empirical"
