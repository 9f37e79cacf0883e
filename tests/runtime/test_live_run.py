"""A few runs on real ports and the real clock: they wait for events, and measure nothing."""

import gc
import os
import select
import signal
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest

from echogrid.drivers.device import Level
from echogrid.drivers.errors import PortError
from echogrid.drivers.readings import RangeReading
from echogrid.emulation.control import request
from echogrid.mapping.reckoning import YawRate
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime import offline, recording, robot_file
from echogrid.runtime.acquisition import DeviceReport
from echogrid.runtime.command_line import main
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.emulator_process import _server, emulator
from echogrid.runtime.live_run import live_run
from echogrid.runtime.log_writer import LogWriter
from echogrid.runtime.service import Run

LONG_S = 30.0
CONTROL = "control.sock"
Reports = dict[str, DeviceReport]


class Watcher:
    """Looks at all devices at every tick, and wakes who waits for something to be so."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._changed = threading.Condition()
        self.reports: Reports = {}
        self.read: Counter[str] = Counter()

    def put(
        self, ranges: tuple[RangeReading, ...], wheels: tuple[WheelAngles, ...], _: tuple[YawRate, ...]
    ) -> None:
        reports = {report.device: report for report in self._run.acquisition.report(self._run.clock.now_ns())}
        with self._changed:
            self.reports = reports
            self.read.update(reading.sensor for reading in ranges)
            self.read["wheels"] += len(wheels)
            self._changed.notify_all()

    def wait(self, holds: Callable[[Reports], bool]) -> Reports:
        with self._changed:
            assert self._changed.wait_for(lambda: holds(self.reports), LONG_S), self.reports
            return self.reports

    def wait_until_all_are_read_again(self) -> None:
        """Twice each, from now on."""
        with self._changed:
            before = self.read.copy()
            assert self._changed.wait_for(
                lambda: all(self.read[n] > c + 1 for n, c in before.items()), LONG_S
            )


def ok(reports: Reports) -> bool:
    return len(reports) == 14 and all(report.health.level is Level.OK for report in reports.values())


def none_ok(reports: Reports) -> bool:
    return len(reports) == 14 and all(report.health.level is not Level.OK for report in reports.values())


def pull_and_plug(folder: Path, watcher: Watcher, names: list[str]) -> Reports:
    """Unplug all of these until every device ails, plug them in again until every one is read: the ailing."""
    for name in names:
        request(folder / CONTROL, {"fault": name, "verb": "unplug"})
    ailing = watcher.wait(none_ok)
    for name in names:
        request(folder / CONTROL, {"clear": name})
    watcher.wait(ok)
    watcher.wait_until_all_are_read_again()
    return ailing


@contextmanager
def in_background(run: Run) -> Iterator[None]:
    """The run's loop in a thread of its own while the context lasts."""
    thread = threading.Thread(target=run.go, args=(None, lambda _: None))
    thread.start()
    try:
        yield
    finally:
        run.stopping = True
        thread.join(LONG_S)
    assert not thread.is_alive()


def test_every_device_and_bus_is_unplugged_and_comes_back_while_the_loop_goes_on(
    short_dir: Path, tmp_path: Path
) -> None:
    config = robot_file.load(DEFAULT_ROBOT)
    devices = [each.name for each in (*config.sensor, *config.wheel)]
    threads, switching_s = set(threading.enumerate()), sys.getswitchinterval()
    with ExitStack() as stack:
        stack.enter_context(emulator(short_dir, 1))
        request(short_dir / CONTROL, {"fault": "rear_left_line", "verb": "unplug"})
        run, closed = stack.enter_context(live_run(config, short_dir))
        assert [trouble.split(": ")[:2] for trouble in closed] == [
            ["rear_left", f"{short_dir}/rear_left_line"]
        ]
        watcher = Watcher(run)
        log = stack.enter_context(LogWriter(tmp_path, DEFAULT_ROBOT.read_text()))
        run.sinks = (watcher, log)
        with in_background(run):
            request(short_dir / CONTROL, {"clear": "rear_left_line"})
            watcher.wait(ok)
            pull_and_plug(short_dir, watcher, devices)
            ailing = pull_and_plug(short_dir, watcher, [bus.name for bus in config.bus])
    assert all("lost" in each.health.message or "open" in each.health.message for each in ailing.values())
    final = watcher.reports
    assert {name: final[name].health.counts["port lost"] for name in ("ring_0", "left", "front_left")} == {
        "ring_0": 1,
        "left": 1,
        "front_left": 2,
    }
    assert all(final[f"ring_{angle}"].health.counts["set-ups"] >= 3 for angle in range(0, 360, 45))
    assert run.loop.punctuality > 0.8
    assert run.fusion.ledger.balances(0)
    assert (log.lost, set(threading.enumerate())) == (0, threads)
    assert (sys.getswitchinterval(), gc.get_freeze_count()) == (switching_s, 0)
    assert not short_dir.exists()
    told = recording.read_simple(tmp_path)
    made = offline.build(told)
    np.testing.assert_array_equal(made.image.occupancy, run.fusion.map_image().occupancy)
    assert made.ledger.balances(0)
    assert set(told.faults.counts) <= {"range outside the pose span"}


@contextmanager
def run_process(short_dir: Path, *arguments: str) -> Iterator["subprocess.Popen[str]"]:
    """`echogrid run` with the emulated robot, once it has shown its first status; and after it the robot is
    gone."""
    command = [sys.executable, "-m", "echogrid", "run", "--dir", str(short_dir), *arguments]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    with process:
        try:
            assert process.stderr is not None
            assert any("readings/s" in line for line in process.stderr)
            robot = _server(short_dir / CONTROL)
            assert robot is not None
            watched = os.pidfd_open(robot)
            yield process
            assert select.select([watched], [], [], LONG_S)[0]
            os.close(watched)
        finally:
            process.kill()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_a_run_with_its_map_which_equals_that_of_its_log(
    short_dir: Path, tmp_path: Path, number: signal.Signals
) -> None:
    out, log, again = tmp_path / "out", tmp_path / "log", tmp_path / "again"
    with run_process(short_dir, "--out", str(out), "--log", str(log)) as process:
        process.send_signal(number)
        told, account = process.communicate(timeout=LONG_S)
    assert process.returncode == 0, account
    assert told.startswith(f"map: {out}/map.yaml")
    assert "ring_0" in account
    assert "Traceback" not in account
    assert not short_dir.exists()
    assert main(["map", str(log), "--out", str(again)]) == 0
    assert (again / "map.npz").read_bytes() == (out / "map.npz").read_bytes()


def test_the_emulated_robot_does_not_outlive_a_run_that_is_killed(short_dir: Path, tmp_path: Path) -> None:
    with run_process(short_dir, "--out", str(tmp_path)) as process:
        process.kill()
    assert not short_dir.exists()


def test_when_no_port_opens_every_device_port_and_mend_is_told(tmp_path: Path) -> None:
    config = robot_file.load(DEFAULT_ROBOT)
    with pytest.raises(PortError) as caught, live_run(config, tmp_path):
        pass
    lines = str(caught.value).splitlines()
    assert lines[-1] == "no port could be opened"
    assert len(lines) == 7
    assert lines[1].startswith(
        f"left, right: {tmp_path}/wheel_bus: cannot open this CAN port: it is not there (is it"
    )
