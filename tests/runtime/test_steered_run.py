"""Robots that steer, emulated: odometry, map, log and faults, from their robot.toml."""

from dataclasses import replace
from math import degrees, hypot
from pathlib import Path
from typing import Any

import pytest

from echogrid.drivers.device import Level
from echogrid.emulation.offices import office_tour
from echogrid.mapping.pose import wrap_angle
from echogrid.runtime import assembly, evaluation, offline, recording, robot_file
from echogrid.runtime.command_line import main
from echogrid.runtime.config import Config
from echogrid.runtime.drive_run import wheel_lines
from echogrid.runtime.emulated import DEFAULT_ROBOT, emulated_robot, office_round, robot_spec
from echogrid.runtime.errors import ConfigError, UsageError
from echogrid.runtime.evaluation import Tape
from echogrid.runtime.lines import lines
from echogrid.runtime.log_writer import LogWriter
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.simulated_run import START_NS, simulated_run
from echogrid.runtime.status import Status

from . import steered

DRIVES = ("tricycle", "ackermann")
OBLIQUE = "zero_deg = 25.0\n"
"""Its encoder is mounted so."""


@pytest.fixture(scope="module", params=DRIVES)
def driven(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Config, Tape]:
    """Such a robot, and what it heard on the first 8 m of its round."""
    config = steered.config(tmp_path_factory.mktemp("robot"), request.param, OBLIQUE)
    return config, evaluation.drive_tour(config, 3, 8.0)


def test_without_noise_its_odometry_ends_within_millimetres(driven: tuple[Config, Tape]) -> None:
    config, tape = driven
    stamp_ns, pose = evaluation.recorded(config, tape).poses[-1]
    way = office_round(config)
    found = evaluation.start_of(way, tape).compose(pose)
    x, y, yaw = way.pose((stamp_ns - START_NS) / SECOND_NS)
    assert hypot(found.x - x, found.y - y) < 0.002
    assert abs(degrees(wrap_angle(found.yaw - yaw))) < 0.1


def test_it_maps_the_office(driven: tuple[Config, Tape]) -> None:
    config, tape = driven
    image = offline.build(evaluation.recorded(config, tape)).image
    assert evaluation.judge(image, evaluation.start_of(office_round(config), tape)).f1 > 0.72


@pytest.mark.parametrize("drive", DRIVES)
def test_the_map_of_its_log_is_that_of_its_run_bit_for_bit(tmp_path: Path, drive: str) -> None:
    steered.config(tmp_path, drive, OBLIQUE)
    run, log, again = (tmp_path / name for name in ("run", "log", "again"))
    told = ["--simulate", "--duration", "12s", "--out", str(run), "--log", str(log)]
    assert main(["run", str(tmp_path / "robot.toml"), *told]) == 0
    assert main(["map", str(log), "--out", str(again)]) == 0
    header, *rows = (log / "wheels.csv").read_text().splitlines()
    assert header == "stamp_s,drive_rad,steering_rad,restarted"
    assert {row.rpartition(",")[2] for row in rows} == {"0"}
    for name in ("map.npz", "map.pgm"):
        assert (run / name).read_bytes() == (again / name).read_bytes()


def faulty_run(config: Config, wheel: str, verb: str, log: LogWriter) -> tuple[Any, list[Status]]:
    """Fourteen seconds; in the seventh the wheel begins to fail, for 0.8 s."""
    run, robot = simulated_run(config, 1)
    run.sinks = (log,)
    looks: list[Status] = []

    def show(status: Status) -> None:
        looks.append(status)
        if len(looks) == 6:
            robot.fault(wheel, verb, run.clock.now_ns(), 4 * SECOND_NS // 5)

    with log:
        run.go(14.0, show)
    return run, looks


@pytest.mark.parametrize("verb", ["off", "unplug", "encoder_lost"])
@pytest.mark.parametrize("wheel", ["drive", "steering"])
def test_a_wheel_that_comes_back_keeps_the_heading_and_a_log_tells_of_its_restart(
    tmp_path: Path, wheel: str, verb: str
) -> None:
    """The circuit begins with a straight line, and goes into its first arc after some 12 s."""
    text, config = steered.text("ackermann", OBLIQUE), steered.config(tmp_path, "ackermann", OBLIQUE)
    log = LogWriter(tmp_path / "log", text, wheels=config.robot.wheels)
    run, looks = faulty_run(config, wheel, verb, log)
    last = looks[-1].snapshot
    yaw = office_round(config).pose((last.pose_ns - START_NS) / SECOND_NS)[2]
    assert yaw > 0.5
    assert degrees(abs(wrap_angle(last.pose.yaw - yaw))) < 1.0
    assert run.fusion.restarts == (1 if wheel == "drive" else 0)
    assert {each.health.level for each in run.devices(run.clock.now_ns())} == {Level.OK}
    again = assembly.odometry(config)
    rows = recording.wheel_rows(tmp_path / "log", config.robot.wheels, recording.RowFaults())
    for stamp_ns, each in rows:
        again.update(stamp_ns, each.both, each.restarted)
    assert [each.restarted for _, each in rows].count(True) == run.fusion.restarts
    assert again.pose == run.fusion.odometry.pose
    assert again.covariance.tobytes() == run.fusion.odometry.covariance.tobytes()


def problem(check: Any, *arguments: Any) -> str:
    with pytest.raises(UsageError) as caught:
        check(*arguments)
    return str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            "wheelbase_m = 0.32",
            "wheelbase_m = 0.32\ntrack_m = 0.3",
            'robot: `track_m` means nothing with drive = "tricycle": take it out',
        ),
        ("wheelbase_m = 0.32", "wheelbase_m = 0.32\nslip_factor = 2.0", "robot: `slip_factor` means nothing"),
        ('drive = "tricycle"', "", 'robot: `wheelbase_m` means nothing with drive = "differential"'),
        ('drive = "tricycle"', 'drive = "trycycle"', "did you mean `tricycle`?"),
        ("wheelbase_m = 0.32", "wheelbase_m = 0.0", "robot: `wheelbase_m` must lie in 0.001...100"),
        ("wheelbase_m = 0.32", "steering_error_deg = 0.0", "robot: `steering_error_deg` must lie in 0...90"),
        ("node = 1\n", "zero_deg = 3.0\n", "wheel[0]: `zero_deg` is for the wheel named `steering`"),
        ("node = 1\n", "most_deg = 30.0\n", "wheel[0]: `most_deg` is for the wheel named `steering`"),
        ("node = 2\n", "most_deg = 190.0\n", "wheel[1]: `most_deg` must lie in 0...180"),
    ],
)
def test_what_makes_no_sense_for_a_drive_is_told_with_its_place(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    text = steered.text("tricycle")
    assert old in text
    path = tmp_path / "robot.toml"
    path.write_text(text.replace(old, new, 1))
    assert told in problem(robot_file.load, path)


def test_an_ackermann_s_steering_can_t_turn_across(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(steered.text("ackermann", "most_deg = 90.0\n"))
    told = problem(robot_file.load, path)
    assert 'wheel[1]: `most_deg` must be at most 85 with drive = "ackermann"' in told


def test_a_run_lacks_what_its_drive_needs(tmp_path: Path) -> None:
    config = steered.config(tmp_path, "tricycle")
    bare = replace(config, robot=replace(config.robot, wheelbase_m=None), wheel=config.wheel[:1])
    assert "`wheel_radius_m` and `wheelbase_m` are needed" in problem(assembly.parts, bare)
    needed = 'a run needs a [[wheel]] named `drive` and one named `steering` (drive = "tricycle")'
    assert needed in problem(assembly.parts, bare)
    assert "`wheel_radius_m` and `wheelbase_m` are needed" in problem(robot_spec, bare)


def test_a_controller_that_can_t_tell_an_angle_is_refused_for_steering_alone(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    text = steered.text("tricycle").replace('"moteus"', '"vesc"')
    path.write_text(text)
    with pytest.raises(ConfigError, match="tachometer begins anew") as caught:
        lines(robot_file.load(path))
    assert [place for place, _ in caught.value.found] == [("wheel", 1)]


def test_its_motors_are_not_commanded(tmp_path: Path) -> None:
    config = steered.config(tmp_path, "tricycle")
    assert "driving by command needs a differential one" in problem(wheel_lines, config)
    with pytest.raises(ConfigError, match="driving by command"):
        emulated_robot(config, 0, 1, driven=True)


def test_an_emulated_ackermann_is_given_no_tour_with_turns_in_place(tmp_path: Path) -> None:
    config = steered.config(tmp_path, "ackermann")
    with pytest.raises(ConfigError, match="can't turn in place: give it a Circuit"):
        emulated_robot(config, 0, 1, tour=office_tour())


def test_a_log_of_another_drive_is_not_read(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with LogWriter(log, DEFAULT_ROBOT.read_text()):
        pass
    (log / "robot.toml").write_text(steered.text("tricycle"))
    assert "the header lacks drive_rad, steering_rad" in problem(recording.read_simple, log)
    (log / "robot.toml").write_text(steered.text("tricycl"))
    assert "the header lacks" not in problem(recording.read_simple, log)


def straight_log(folder: Path, drive: str, scale: float, zero: float) -> Path:
    """5 m straight on, by an encoder whose zero is that many rad off."""
    folder.mkdir()
    (folder / "robot.toml").write_text(steered.text(drive, OBLIQUE))
    rows = [f"{0.1 * n:.1f},{n * 0.05 / 0.06 / scale!r},{zero!r}" for n in range(101)]
    (folder / "wheels.csv").write_text("\n".join(["stamp_s,drive_rad,steering_rad", *rows, ""]))
    return folder


@pytest.mark.parametrize("drive", DRIVES)
def test_a_straight_run_calibrates_radius_and_zero_and_writes_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], drive: str
) -> None:
    log = straight_log(tmp_path / "log", drive, 1.02, 0.03)
    path = log / "robot.toml"
    told = ["calibrate", "odometry", str(log), "--straight", "5", "--write", str(path)]
    assert main(told) == 0
    said = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in said[1:3]] == ["wheel_radius_m", "zero_deg"]
    assert said[-1] == f"{path}: wheel_radius_m, zero_deg changed"
    found = robot_file.load(path)
    assert found.wheel[1].zero_deg == pytest.approx(25.0 + degrees(0.03), abs=1e-4)
    assert found.robot.wheel_radius_m == pytest.approx(0.06 * 1.02, rel=1e-6)


def test_squares_are_for_differential_drives_and_that_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = straight_log(tmp_path / "log", "tricycle", 1.0, 0.0)
    assert main(["calibrate", "odometry", str(log), "--square"]) == 2
    told = capsys.readouterr().err
    assert 'squares are for a differential drive, and this is drive = "tricycle": let it go straight' in told


def test_without_a_steering_in_the_file_its_zero_is_told_to_be_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = straight_log(tmp_path / "log", "tricycle", 1.0, 0.1)
    text = (log / "robot.toml").read_text()
    bare = text[: text.index("[[wheel]]")] + text[text.index("[[sensor]]") :]
    (tmp_path / "bare.toml").write_text(bare)
    told = ["calibrate", "odometry", str(log), "--straight", "5", "--write", str(tmp_path / "bare.toml")]
    assert main(told) == 2
    assert "no [[wheel]] named `steering`: write it yourself" in capsys.readouterr().err
    assert (tmp_path / "bare.toml").read_text() == bare
