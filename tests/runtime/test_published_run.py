"""A run on real ports that publishes what the docs say, whoever listens."""

import json
import socket
import threading
from contextlib import closing
from itertools import pairwise
from pathlib import Path

from echogrid.runtime import robot_file
from echogrid.runtime.command_line import main
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.emulator_process import emulator
from echogrid.runtime.live_run import live_run

from .told_view import told

LONG_S = 30.0
OUTPUTS = """
[[output]]
type = "unix"
path = "binary.sock"
rate_hz = 50

[[output]]
type = "unix"
path = "nobody.sock"
format = "json"

[[output]]
type = "can"
bus = "wheel_bus"
id = 0x300
"""


def test_views_come_out_of_a_live_run_in_order_and_all_are_accounted_for(tmp_path: Path) -> None:
    robot = tmp_path / "publishing.toml"
    robot.write_text(DEFAULT_ROBOT.read_text() + OUTPUTS)
    with closing(socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)) as bound, emulator(tmp_path, 1):
        bound.bind(str(tmp_path / "binary.sock"))
        bound.settimeout(LONG_S)
        with live_run(robot_file.load(robot), tmp_path) as (run, closed):
            assert closed == []
            thread = threading.Thread(target=run.go, args=(None, lambda _: None))
            thread.start()
            views = [told(bound.recv(65536)) for _ in range(40)]
            run.stopping = True
            thread.join(LONG_S)
            report = run.report(run.devices(run.clock.now_ns()))["outputs"]
    assert [view.sequence for view in views] == list(range(40))
    assert all(after.stamp_ns > before.stamp_ns for before, after in pairwise(views))
    assert len(views[0].sectors) == 16
    assert views[0].speed_limit <= 0.11
    assert report["unix:binary.sock"]["sent"] >= 40
    assert report["unix:nobody.sock"]["sent"] == 0
    assert report["unix:nobody.sock"]["dropped"]["no receiver"] > 0
    assert report["can:wheel_bus:0x300"]["sent"] > 0


def test_an_output_without_a_receiver_makes_no_run_fail_and_is_in_its_report(tmp_path: Path) -> None:
    robot = tmp_path / "publishing.toml"
    robot.write_text(DEFAULT_ROBOT.read_text() + OUTPUTS)
    with emulator(tmp_path, 1):
        assert main(["run", str(robot), "--duration", "2s", "--out", str(tmp_path / "out")]) == 0
    outputs = json.loads((tmp_path / "out" / "report.json").read_text())["outputs"]
    assert set(outputs) == {"unix:binary.sock", "unix:nobody.sock", "can:wheel_bus:0x300"}
