"""A robot with a gyro: its pose while wheels slip, its flag, its log."""

import json
from collections.abc import Sequence
from dataclasses import replace
from io import StringIO
from math import degrees, hypot
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from echogrid.drivers.readings import GyroReading
from echogrid.emulation.motion import Tour
from echogrid.emulation.offices import office_tour
from echogrid.emulation.world import World
from echogrid.mapping.pose import wrap_angle
from echogrid.runtime import assembly, calibration, lone_device, map_files, recording, robot_file
from echogrid.runtime.command_line import main
from echogrid.runtime.config import Config, FiringConfig
from echogrid.runtime.console import Console
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.errors import ConfigError, UsageError
from echogrid.runtime.lines import line_of
from echogrid.runtime.log_writer import LogWriter
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.odometry_check import square
from echogrid.runtime.reading_text import as_line, as_object
from echogrid.runtime.simulated_run import START_NS, simulated_run
from echogrid.runtime.status import Status

from .gyro_robot import GYRO, ROBOT, Mishap, Mishaps

WAIT_S = 3.0
SQUARE = replace(square(2.0, 1), wait=WAIT_S)
NOWHERE = World("nowhere", np.zeros((0, 4)), np.zeros(0, np.bool_), np.zeros((0, 3)))
SPINS: tuple[Mishap, ...] = ((5.0, "left", "slip", 1.0), (15.0, "right", "slip", 1.0))
SECOND = """[[gyro]]
name = "other"
driver = "gyro-text"
bus = "front_left_line"

"""
FORCED: tuple[Mishap, ...] = (
    *SPINS,
    (2.5, "gyro", "intermittent", 1.0),
    (6.0, "gyro", "off", 0.8),
    (9.0, "gyro", "delayed", 1.0),
    (11.0, "right", "off", 0.6),
    (13.0, "gyro", "garbage", 0.4),
    (17.0, "gyro_line", "unplug", 0.5),
)


class Drive(NamedTuple):
    """How a lap ended, and what was told of it."""

    off: float
    """m."""
    turned: float
    """degrees."""
    news: str
    lines: list[str]
    report: dict[str, Any]


def loaded(tmp_path: Path, text: str) -> Config:
    (tmp_path / "robot.toml").write_text(text)
    return robot_file.load(tmp_path / "robot.toml")


def lean(config: Config) -> Config:
    """With one ranger alone."""
    buses = {config.sensor[0].bus, *(each.bus for each in (*config.wheel, *config.gyro))}
    kept = tuple(bus for bus in config.bus if bus.name in buses)
    return replace(config, sensor=config.sensor[:1], bus=kept, firing=FiringConfig())


def drive(config: Config, mishaps: Sequence[Mishap], tour: Tour = SQUARE) -> Drive:
    """Once round the square with its wheels, its gyro if it has one, and one ranger that hears nothing."""
    run, robot = simulated_run(lean(config), 1, NOWHERE, tour)
    run.sinks = (Mishaps(run, robot, mishaps),)
    stream, lines = StringIO(), []
    console = Console(stream)

    def show(status: Status) -> None:
        console.show_changes(status)
        lines.append(status.line())

    run.go(WAIT_S + tour.lap_time + 1.0, show)
    stamp_ns, pose = run.path[-1]
    x, y, yaw = tour.pose((stamp_ns - START_NS) / SECOND_NS)
    off, turned = hypot(pose.x - x, pose.y - y), degrees(wrap_angle(pose.yaw - yaw))
    return Drive(off, abs(turned), stream.getvalue(), lines, run.report(run.devices(run.clock.now_ns())))


@pytest.fixture
def with_gyro(tmp_path: Path) -> Config:
    return loaded(tmp_path, ROBOT)


@pytest.fixture
def without(tmp_path: Path) -> Config:
    return loaded(tmp_path, DEFAULT_ROBOT.read_text())


def test_a_gyro_keeps_the_pose_when_wheels_spin_and_the_flag_comes(
    with_gyro: Config, without: Config
) -> None:
    helped, alone = drive(with_gyro, SPINS[:1]), drive(without, SPINS[:1])
    assert alone.turned > 30.0
    assert alone.off > 0.3
    assert helped.turned < 0.3
    assert helped.off < alone.off / 3.0
    assert helped.news.count("odometry: wheels slip: wheels and gyro disagree") == 1
    assert helped.news.count("odometry: wheels and gyro agree again") == 1
    assert sum("SLIP" in line for line in helped.lines) in (1, 2)
    assert helped.report["wheel_slips"] == 1
    assert 1.5 < helped.report["wheel_slip_s"] < 2.1
    assert "wheel_slips" not in alone.report


def test_without_slip_there_is_no_flag_and_the_bias_is_found(with_gyro: Config) -> None:
    told = drive(with_gyro, ())
    assert told.turned < 0.3
    assert told.off < 0.02
    assert "slip" not in told.news
    report = told.report
    assert (report["wheel_slips"], report["wheel_slip_s"], report["gyro_readings_late"]) == (0, 0.0, 0)
    assert report["gyro_bias_dps"] == pytest.approx(-0.5 * -1.0, abs=0.02)
    assert report["readings_by_device"]["gyro"] > 2000


def test_the_pose_is_surer_with_a_gyro(with_gyro: Config, without: Config) -> None:
    helped, alone = drive(with_gyro, ()), drive(without, ())
    assert helped.report["pose_error"]["yaw_deg"] < alone.report["pose_error"]["yaw_deg"] / 5.0


def test_a_gyro_without_power_leaves_the_wheels_alone(with_gyro: Config) -> None:
    told = drive(with_gyro, ((0.0, "gyro", "off", 60.0),))
    assert told.off < 0.01
    assert told.report["gyro_bias_dps"] is None
    assert told.report["devices"]["gyro"]["level"] == "STALE"


def test_a_serial_gyro_that_is_unplugged_is_told_and_found_again(with_gyro: Config) -> None:
    told = drive(with_gyro, ((6.0, "gyro", "unplug", 2.0),))
    assert "gyro: ERROR: " in told.news
    assert "gyro: OK: turning measured" in told.news
    assert told.off < 0.02


def test_a_gyro_that_drifts_is_flagged(with_gyro: Config) -> None:
    told = drive(with_gyro, ((5.0, "gyro", "drifting", 60.0),))
    assert told.report["wheel_slips"] >= 1
    assert "wheels and gyro disagree" in told.news


@pytest.fixture(scope="module")
def forced(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run through the office, with a log, in which wheels and gyro fail in all ways."""
    folder = tmp_path_factory.mktemp("forced")
    config = loaded(folder, ROBOT)
    run, robot = simulated_run(config, 3, tour=replace(office_tour(), wait=WAIT_S))
    with LogWriter(folder / "log", ROBOT, with_gyro=True) as log:
        mishaps = Mishaps(run, robot, FORCED)
        run.sinks = (log, mishaps)
        run.go(20.0, lambda _: None)
    assert mishaps.happened == set(FORCED)
    assert run.fusion.restarts >= 1
    map_files.write(folder / "out", run.fusion.map_image(), run.path)
    (folder / "report.json").write_text(json.dumps(run.report([])))
    return folder


def test_the_map_of_a_log_with_gyro_is_that_of_the_run_bit_for_bit(forced: Path, tmp_path: Path) -> None:
    assert main(["map", str(forced / "log"), "--out", str(tmp_path)]) == 0
    assert (tmp_path / "map.npz").read_bytes() == (forced / "out/map.npz").read_bytes()
    report = json.loads((forced / "report.json").read_text())
    assert report["wheel_slips"] >= 2


def test_so_are_its_poses(forced: Path) -> None:
    poses = dict(recording.read_simple(forced / "log").poses)
    last_s, *last = (forced / "out/trajectory.tum").read_text().splitlines()[-1].split()
    at_ns = min(poses, key=lambda stamp_ns: abs(stamp_ns - round(float(last_s) * 1e9)))
    assert (poses[at_ns].x, poses[at_ns].y) == pytest.approx([float(each) for each in last[:2]], abs=1e-6)


def test_the_gyro_matters_to_that_map(forced: Path, tmp_path: Path) -> None:
    (tmp_path / "log").mkdir()
    for name in ("robot.toml", "ranges.csv", "wheels.csv"):
        (tmp_path / "log" / name).write_bytes((forced / "log" / name).read_bytes())
    assert main(["map", str(tmp_path / "log"), "--out", str(tmp_path)]) == 0
    assert (tmp_path / "map.npz").read_bytes() != (forced / "out/map.npz").read_bytes()


def test_a_row_of_the_gyro_s_that_cannot_be_used_is_skipped_and_told(
    forced: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "log").mkdir()
    for name in ("robot.toml", "ranges.csv", "wheels.csv"):
        (tmp_path / "log" / name).write_bytes((forced / "log" / name).read_bytes())
    rows = (forced / "log/gyro.csv").read_text().splitlines()
    (tmp_path / "log/gyro.csv").write_text("\n".join([*rows[:9], "1.0,fast", "1.0,inf", *rows[9:]]))
    assert main(["map", str(tmp_path / "log"), "--out", str(tmp_path)]) == 0
    assert (tmp_path / "map.npz").read_bytes() == (forced / "out/map.npz").read_bytes()
    told = capsys.readouterr().err
    assert "gyro.csv:10: unparsable: 1 row skipped from here on" in told
    assert "gyro.csv:11: non-finite value: 1 row skipped from here on" in told


def test_a_gyro_file_without_its_columns_is_told(forced: Path, tmp_path: Path) -> None:
    for name in ("robot.toml", "ranges.csv", "wheels.csv"):
        (tmp_path / name).write_bytes((forced / "log" / name).read_bytes())
    (tmp_path / "gyro.csv").write_text("stamp_s,rate_dps\n")
    with pytest.raises(UsageError, match=r"gyro\.csv:1: the header lacks rate_rad_s"):
        recording.read_simple(tmp_path)


def test_a_run_from_the_command_line_logs_its_gyro_and_its_map_is_that_of_the_log(tmp_path: Path) -> None:
    (tmp_path / "robot.toml").write_text(ROBOT)
    arguments = ["run", str(tmp_path / "robot.toml"), "--simulate", "--duration", "8s"]
    assert main([*arguments, "--log", str(tmp_path / "log"), "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "log/gyro.csv").read_text().startswith("stamp_s,rate_rad_s\n")
    assert main(["map", str(tmp_path / "log"), "--out", str(tmp_path / "again")]) == 0
    assert (tmp_path / "again/map.npz").read_bytes() == (tmp_path / "out/map.npz").read_bytes()


def test_wheels_are_calibrated_by_wheels_alone(tmp_path: Path) -> None:
    """A gyro would mend what is to be found."""
    config = loaded(tmp_path, ROBOT)
    body = replace(config.robot, wheel_ratio=1.003, track_m=0.317)
    folders = []
    for turn in (-1, 1):
        tour = replace(square(2.0, turn), wait=WAIT_S)
        run, _ = simulated_run(lean(config), 1, NOWHERE, tour, body)
        folders.append(tmp_path / str(turn))
        with LogWriter(folders[-1], ROBOT, with_gyro=True) as log:
            run.sinks = (log,)
            run.go(WAIT_S + tour.lap_time, lambda _: None)
    found = calibration.by_squares(calibration.read(folders, {})).new
    assert found.wheel_ratio == pytest.approx(1.003, abs=5e-4)
    assert found.track_m == pytest.approx(0.317, abs=1e-3)


def test_a_gyro_s_reading_as_text_and_for_programs() -> None:
    reading = GyroReading(1_500_000_000, 2, "gyro", 0.5, b"28.6")
    assert as_line(reading, 1_000_000_000) == "    0.500 s  gyro  +28.648 deg/s  [32 38 2e 36]"
    assert as_object(reading) == {
        "gyro": "gyro",
        "rate_rad_s": 0.5,
        "stamp_ns": 1_500_000_000,
        "stamp_error_ns": 2,
        "raw": "32382e36",
    }


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('name = "gyro"', 'name = "left"', "`name` is taken: there is a [[wheel]] named 'left'"),
        ('name = "gyro"', 'name = "ring_0"', "`name` is taken: there is a [[sensor]] named 'ring_0'"),
        ('bus = "gyro_line"', 'bus = "gyro_lines"', "there is no [[bus]] named 'gyro_lines'"),
        ("scale = -1.0", "scale = -1.0\nturn_error_deg = 0.0", "`turn_error_deg` must lie in 0...90"),
        ("[[gyro]]", SECOND + "[[gyro]]", "a second [[gyro]]: one at most is used"),
    ],
)
def test_what_is_wrong_with_a_gyro_is_told(tmp_path: Path, old: str, new: str, told: str) -> None:
    with pytest.raises(UsageError) as caught:
        loaded(tmp_path, ROBOT.replace(GYRO, GYRO.replace(old, new, 1)))
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('driver = "gyro-text"', 'driver = "srf08"', "srf08 is for a [[sensor]] or [[wheel]]"),
        ('driver = "gyro-text"', 'driver = "gyro-dbc"', "gyro-dbc speaks can, but bus 'gyro_line' is serial"),
        ('driver = "a02yyuw"', 'driver = "gyro-text"', "gyro-text is for a [[gyro]]"),
        ("scale = -1.0", "scale = 0.0", "scale is 0.0"),
        ("scale = -1.0", "scail = 1.0", "did you mean `scale`?"),
        ('bus = "gyro_line"', 'bus = "front_left_line"', "share the serial line"),
    ],
)
def test_what_is_wrong_with_its_driver_is_told(tmp_path: Path, old: str, new: str, told: str) -> None:
    config = loaded(tmp_path, ROBOT.replace(old, new, 1))
    with pytest.raises(ConfigError) as caught:
        assembly.parts(config)
    assert told in str(caught.value)


def test_a_gyro_is_found_by_its_name_or_its_driver_s(with_gyro: Config) -> None:
    by_name = lone_device.alone(with_gyro, "gyro")
    assert (by_name.sensor, by_name.wheel, len(by_name.gyro)) == ((), (), 1)
    by_driver = lone_device.on_port("gyro-text", "/dev/ttyUSB0", {"baud": 9600})
    assert dict(line_of(by_driver).devices[0].port_options) == {"baud": 9600}
