"""`echogrid emulate`, stopped at once: what it leaves in its folder."""

import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from echogrid.emulation.server import Server
from echogrid.runtime import robot_file
from echogrid.runtime.command_line import main
from echogrid.runtime.emulated import DEFAULT_ROBOT

Seen = Callable[[], dict[str, str]]


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch, short_dir: Path) -> Seen:
    """What is in robot.toml while it serves; it serves no longer than that takes to read."""
    texts: dict[str, str] = {}

    def read_and_stop(server: Server, stop: threading.Event) -> None:
        texts["robot.toml"] = (short_dir / "robot.toml").read_text()

    monkeypatch.setattr(Server, "run", read_and_stop)
    return lambda: texts


def test_a_description_to_run_with_stands_beside_the_ports_while_it_serves(
    short_dir: Path, seen: Seen
) -> None:
    assert main(["emulate", "--dir", str(short_dir)]) == 0
    first, rest = seen()["robot.toml"].split("\n", 1)
    assert first.startswith("# A copy")
    assert rest == DEFAULT_ROBOT.read_text()
    assert not short_dir.exists()


def test_a_description_of_the_user_s_own_in_the_folder_stays(short_dir: Path, seen: Seen) -> None:
    short_dir.mkdir()
    own = short_dir / "robot.toml"
    own.write_text(DEFAULT_ROBOT.read_text())
    assert main(["emulate", str(own), "--dir", str(short_dir)]) == 0
    assert own.read_text() == seen()["robot.toml"] == DEFAULT_ROBOT.read_text()


def test_what_a_killed_emulator_left_is_replaced(short_dir: Path, seen: Seen) -> None:
    short_dir.mkdir()
    (short_dir / "robot.toml").write_text("# A copy, which goes when the emulated robot does.\nold")
    assert main(["emulate", "--dir", str(short_dir)]) == 0
    assert "old" not in seen()["robot.toml"].splitlines()
    assert list(short_dir.iterdir()) == []


def test_the_copy_can_be_read(short_dir: Path, seen: Seen, tmp_path: Path) -> None:
    assert main(["emulate", "--dir", str(short_dir)]) == 0
    copy = tmp_path / "robot.toml"
    copy.write_text(seen()["robot.toml"])
    assert robot_file.load(copy) == robot_file.load(DEFAULT_ROBOT)


def test_a_storm_of_signals_ends_it_all_the_same(short_dir: Path) -> None:
    command = [sys.executable, "-m", "echogrid", "emulate", "--dir", str(short_dir)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        assert "the emulated robot is in" in process.stderr.readline()
        for _ in range(50):
            process.send_signal(signal.SIGTERM)
            process.send_signal(signal.SIGHUP)
        assert process.wait(timeout=20) == 0
    assert not short_dir.exists()
