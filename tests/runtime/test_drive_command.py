"""echogrid run with a drive mode, as it is typed."""

import json
import re
import signal
import socket
import subprocess
import sys
import time
from contextlib import closing
from math import radians
from pathlib import Path

import pytest

from echogrid.mapping.twist import Twist
from echogrid.runtime.command_line import main
from echogrid.runtime.config import DriveConfig
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.emulator_process import emulator
from echogrid.runtime.errors import UsageError
from echogrid.runtime.modes import sources

from .driven_run import Wisher

LIMITS = DriveConfig(max_speed_mps=0.4, max_turn_dps=60.0)


def test_a_simulated_robot_drives_to_its_goal(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--simulate", "--goto", "1", "-0.1", "--out", str(tmp_path)]) == 0
    drive = json.loads((tmp_path / "report.json").read_text())["drive"]
    assert drive["mode"] == "goto"
    assert 0.8 < drive["distance_m"] < 1.2
    err = capfd.readouterr().err
    assert "goto: driving" in err
    assert "there: x 0.8" in err


def test_a_goal_that_is_not_reached_is_1_in_words(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    strict = tmp_path / "robot.toml"
    strict.write_text(DEFAULT_ROBOT.read_text().replace('unknown = "slow"', 'unknown = "blocked"'))
    assert main(["run", str(strict), "--simulate", "--goto", "3", "0", "--out", str(tmp_path)]) == 1
    assert re.search(
        r"stuck: x -?\d\.\d\d m, y -?\d\.\d\d m, \d\.\d\d m from the goal", capfd.readouterr().err
    )


def test_the_emulated_robot_that_comes_with_a_run_is_driven(tmp_path: Path, short_dir: Path) -> None:
    told = ["run", "--goto", "0.6", "0", "--dir", str(short_dir), "--out", str(tmp_path), "--duration", "30s"]
    assert main(told) == 0
    assert json.loads((tmp_path / "report.json").read_text())["drive"]["end"].startswith("there: ")


def test_a_robot_heeds_wishes_and_is_let_go_when_it_is_told_to_end(tmp_path: Path, short_dir: Path) -> None:
    """On the real clock, in three processes."""
    wisher = Wisher(tmp_path / "wishes", Twist(0.2, 0.1))
    run = ["run", f"{short_dir}/robot.toml", "--guard", f"unix:{wisher.address}", "--out", str(tmp_path)]
    with emulator(short_dir, 1, driven=True), closing(wisher.sender):
        process = subprocess.Popen([sys.executable, "-m", "echogrid", *run])
        until = time.monotonic() + 8.0
        while time.monotonic() < until:
            time.sleep(0.05)
            if wisher.address.is_socket():
                wisher.put((), (), ())
        wisher.sender.sendto(b"faster", str(wisher.address))
        time.sleep(0.1)
        process.send_signal(signal.SIGTERM)
        assert process.wait(20.0) == 0
    drive = json.loads((tmp_path / "report.json").read_text())["drive"]
    assert (drive["mode"], drive["end"], drive["refused"]) == ("guard", None, {"no JSON": 1})
    assert drive["distance_m"] > 0.2


def test_nobody_can_wish_on_a_clock_that_jumps(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--simulate", "--guard", "udp:7655"]) == 2
    assert "--guard: nobody can wish in time on the clock of --simulate" in capfd.readouterr().err


def test_wishes_are_heard_where_they_are_said_to_be(tmp_path: Path) -> None:
    path = tmp_path / "wishes"
    wishes = sources.opened(f"unix:{path}", LIMITS)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.sendto(b'{"speed": 0.25, "turn_rate": 0.5}', str(path))
    assert wishes.poll(0) == Twist(0.25, 0.5)
    wishes.close()


def test_a_joystick_at_full_deflection_wishes_for_the_limits(tmp_path: Path) -> None:
    events = [(32767, 1, 4), (-32767, 2, 1), (-32767, 2, 0)]
    device = tmp_path / "js0"
    data = b"".join(
        bytes(4) + value.to_bytes(2, "little", signed=True) + bytes((kind, number))
        for value, kind, number in events
    )
    device.write_bytes(data)
    wishes = sources.opened(f"joystick:{device}", LIMITS)
    assert wishes.poll(0) == Twist(0.4, radians(60.0))
    wishes.close()


@pytest.mark.parametrize("source", ["", "udp", "udp:", "udp:x", "unix:", "joystick:", "serial:/dev/ttyS0"])
def test_what_is_no_source_is_told_with_those_that_are(source: str) -> None:
    with pytest.raises(UsageError, match=r"not a source of wishes .*udp:HOST:PORT"):
        sources.opened(source, LIMITS)


def test_a_source_that_can_t_be_opened_is_told(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no such port"):
        sources.opened("udp:70000", LIMITS)
    with pytest.raises(UsageError, match=r"nowhere/wishes: No such file"):
        sources.opened(f"unix:{tmp_path}/nowhere/wishes", LIMITS)
