import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from math import pi, radians
from pathlib import Path
from typing import Any

from pytest import approx, fixture, raises

from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.device import Health, State
from echogrid.drivers.readings import WheelReading
from echogrid.emulation.control import request
from echogrid.emulation.robot import EmulatedRobot
from echogrid.mapping.pose import Pose
from echogrid.runtime import assembly, robot_file
from echogrid.runtime.acquisition import DeviceReport
from echogrid.runtime.config import Config, DriveConfig, LoopConfig
from echogrid.runtime.drive_run import DriveRun, drive_loop, pumped, wheel_lines
from echogrid.runtime.driving import Driving
from echogrid.runtime.emulated import DEFAULT_ROBOT, emulated_robot
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.excursion import Excursion, Stage, Wanted
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulation import Simulation

SECOND = 1_000_000_000
START = SECOND
COMMAND = (sys.executable, "-m", "echogrid")
LONG_S = 20.0
CIA402 = {"counts_per_turn": 4096.0}


@fixture
def config() -> Config:
    return robot_file.load(DEFAULT_ROBOT)


class Drive:
    """The built-in robot, driven on a clock that jumps."""

    def __init__(self, config: Config, wanted: Wanted) -> None:
        clock, queue = JumpingClock(START), ReadingQueue()
        devices, driving = wheel_lines(config)
        self.robot: EmulatedRobot = emulated_robot(config, START, 1, driven=True)
        ports: dict[str, Any] = dict(self.robot.ports(clock))
        simulation = Simulation(clock, pumped(devices, ports, clock, queue), queue)
        self.excursion = Excursion(driving, wanted)
        loop = drive_loop(simulation, config)
        self.run = DriveRun(self.excursion, assembly.odometry(config), loop, simulation)
        self.stages: list[Stage] = []
        self.clock = clock
        self.fails = ""
        """The wheel whose motor fails under way."""

    def go(self) -> Pose:
        self.run.go(self._show)
        return self.run.odometry.pose

    def _show(self, stage: Stage, pose: Pose) -> None:
        if self.fails and pose.x > 0.1:
            self.robot.fault(self.fails, "motor_failed", self.clock.now_ns())
            self.fails = ""
        if self.stages[-1:] != [stage]:
            self.stages.append(stage)


def test_it_enables_drives_stops_and_lets_go(config: Config) -> None:
    drive = Drive(config, Wanted(0.3, 0.0, 4 * SECOND))
    pose = drive.go()
    assert drive.stages == [Stage.ENABLING, Stage.DRIVING, Stage.STOPPING, Stage.LETTING_GO, Stage.OVER]
    assert drive.excursion.trouble == ""
    # It speeds up with 0.5 m/s^2, and stops within its controller's own time.
    assert pose.x == approx(0.3 * 4.0 - 0.3**2 / 2 / 0.5, abs=0.03)
    assert (pose.y, pose.yaw) == approx((0.0, 0.0), abs=1e-3)


def test_a_turn_is_counter_clockwise(config: Config) -> None:
    pose = Drive(config, Wanted(0.0, radians(45.0), 2 * SECOND)).go()
    assert pose.yaw == approx(pi / 2, abs=0.3)
    assert pose.x == approx(0.0, abs=0.01)


def test_what_is_asked_is_kept_within_the_limits_on_the_same_curve(config: Config) -> None:
    limited = replace(config, drive=DriveConfig(max_speed_mps=0.4, max_turn_dps=60.0))
    driving = Driving(limited, assembly.differential(limited, "this test"))
    assert driving.ask(0, 0.8, 0.2) == approx((0.4, 0.1))
    assert driving.ask(0, 0.1, radians(120.0)) == approx((0.05, radians(60.0)))
    slow = replace(limited, wheel=tuple(replace(wheel, fastest_rad_s=2.0) for wheel in limited.wheel))
    speed, turn_rate = Driving(slow, assembly.differential(slow, "this test")).ask(0, -0.4, 0.0)
    assert speed == approx(-2.0 * (config.robot.wheel_radius_m or 0.0))
    assert turn_rate == 0.0


def test_a_motor_that_fails_ends_the_drive_and_says_which(config: Config) -> None:
    drive = Drive(config, Wanted(0.3, 0.0, 10 * SECOND))
    drive.fails = "left"
    pose = drive.go()
    assert drive.stages[-1] is Stage.OVER
    assert "stopped early: left: failed: motor error" in drive.excursion.trouble
    assert 0.1 < pose.x < 0.6


def test_motors_that_are_not_there_are_told_after_five_seconds(config: Config) -> None:
    drive = Drive(config, Wanted(0.3, 0.0, SECOND))
    drive.robot.fault("right", "off", START)
    drive.go()
    assert drive.stages == [Stage.ENABLING, Stage.STOPPING, Stage.LETTING_GO, Stage.OVER]
    assert "the motors can't be enabled" in drive.excursion.trouble
    assert "right: silent: no heartbeat" in drive.excursion.trouble


class Enabled:
    """An excursion whose motors obey, ticked by hand."""

    def __init__(self, config: Config, lasts_ns: int) -> None:
        self.driving = Driving(config, assembly.differential(config, "this test"))
        self.excursion = Excursion(self.driving, Wanted(0.3, 0.0, lasts_ns))
        for throttle in self.driving.throttles.values():
            throttle.obeyed = True

    def tick(self, now_ns: int, state: State = State.WELL, rate: float = 0.0) -> Stage:
        reports = [DeviceReport(name, "bus", Health(state, "so", {})) for name in self.driving.throttles]
        readings = [WheelReading(now_ns, 0, name, 0.0, rate, False, b"") for name in self.driving.throttles]
        self.excursion.tick(now_ns, readings, reports)
        return self.excursion.stage

    def asked(self, now_ns: int) -> list[float | None]:
        return [throttle.rate(now_ns) for throttle in self.driving.throttles.values()]


def test_a_wheel_that_is_not_well_is_not_turned_though_its_motor_obeys(config: Config) -> None:
    enabled = Enabled(config, SECOND)
    for tick in range(100):
        assert enabled.tick(tick * SECOND // 20, State.STALLED) is Stage.ENABLING
        assert enabled.asked(tick * SECOND // 20) == [0.0, 0.0]
    assert enabled.tick(5 * SECOND, State.STALLED) is Stage.STOPPING
    assert "the motors can't be enabled: left: stalled: so" in enabled.excursion.trouble


def test_after_a_pause_in_which_the_wheels_were_stopped_they_don_t_start_by_themselves(
    config: Config,
) -> None:
    enabled = Enabled(config, 60 * SECOND)
    assert [enabled.tick(tick * SECOND // 5) for tick in range(3)] == [Stage.DRIVING] * 3
    assert enabled.tick(3 * SECOND) is Stage.STOPPING
    assert enabled.asked(3 * SECOND) == [0.0, 0.0]
    assert "stopped early: it paused for 2.6 s" in enabled.excursion.trouble


def test_wheels_that_do_not_stop_are_told(config: Config) -> None:
    enabled = Enabled(config, SECOND)
    stages = [enabled.tick(tick * SECOND // 20, rate=5.0) for tick in range(70)]
    assert stages[-1] is Stage.OVER
    assert "the wheels still turned when they were let go: left: well" in enabled.excursion.trouble


def test_a_slow_loop_of_the_robot_does_not_make_it_stutter(config: Config) -> None:
    drive = Drive(replace(config, loop=LoopConfig(rate_hz=2.0)), Wanted(0.3, 0.0, 4 * SECOND))
    assert drive.go().x == approx(0.3 * 4.0 - 0.3**2 / 2 / 0.5, abs=0.03)


def test_it_can_be_stopped_at_any_time(config: Config) -> None:
    drive = Drive(config, Wanted(0.3, 0.0, 100 * SECOND))
    drive.excursion.stop()
    assert drive.go().x == approx(0.0, abs=1e-3)
    assert drive.stages[0] is Stage.STOPPING


def test_wheels_that_can_t_be_driven_are_refused(config: Config) -> None:
    silent = replace(config, bus=tuple(replace(bus, listen_only=bus.kind == "can") for bus in config.bus))
    with raises(ConfigError, match="left can't be driven: bus 'wheel_bus' has listen_only = true"):
        wheel_lines(silent)
    with raises(ConfigError) as told:
        wheel_lines(
            replace(
                silent,
                wheel=tuple(
                    replace(wheel, driver="cia402", settings=CIA402 | {"node": n})
                    for n, wheel in enumerate(silent.wheel, 1)
                ),
            )
        )
    assert "configure" not in str(told.value)
    deaf = replace(
        config, wheel=tuple(replace(wheel, driver="ak-servo", settings={}) for wheel in config.wheel)
    )
    with raises(ConfigError, match="left can't be driven: its driver only listens"):
        wheel_lines(deaf)


@contextmanager
def emulated(folder: Path, text: str) -> Iterator[Path]:
    """A robot that waits for its motors' commands, in a process of its own; its description."""
    own = folder / "own.toml"
    own.write_text(text)
    ports = folder / "ports"
    process = subprocess.Popen([*COMMAND, "emulate", str(own), "--driven", "--dir", str(ports)])
    try:
        until = time.monotonic() + LONG_S
        while not (ports / "robot.toml").exists():
            assert time.monotonic() < until
            time.sleep(0.02)
        yield ports
    finally:
        process.terminate()
        process.wait(LONG_S)


def angle_of(ports: Path, wheel: str) -> float:
    shown = subprocess.run(
        [*COMMAND, "read", wheel, "--dir", str(ports), "--count", "1"],
        capture_output=True,
        text=True,
        timeout=LONG_S,
        check=True,
    )
    return float(shown.stdout.split()[3])


def test_killed_in_the_middle_the_controllers_own_watchdogs_stop_the_wheels(short_dir: Path) -> None:
    short_dir.mkdir(exist_ok=True)
    with emulated(short_dir, DEFAULT_ROBOT.read_text()) as ports:
        request(ports / "control.sock", {"list": True})
        drive = subprocess.Popen(
            [*COMMAND, "drive", "--dir", str(ports), "--forward", "0.3", "--for", "60s"],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert drive.stdout is not None
        with closing(drive.stdout) as lines:
            assert any(line.startswith("driving") and "x +0.0" not in line for line in lines)
            os.kill(drive.pid, signal.SIGKILL)
            drive.wait(LONG_S)
        time.sleep(1.5)
        before = angle_of(ports, "left")
        time.sleep(0.5)
        assert angle_of(ports, "left") == before > 1.0
