import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from echogrid.emulation.robot import RangerSpec
from echogrid.runtime.command_line import main

from .served import served

WALL = 1.5


@pytest.fixture
def robot(short_dir: Path) -> Iterator[Path]:
    """The folder of a robot with two I2C rangers, two that talk by themselves and one which is spoken to."""
    rangers = [
        RangerSpec("front", "srf08", "ring", 0.0, 0.0, 0.0, {"address": 0x71}),
        RangerSpec("rear", "srf08", "ring", 0.0, 0.0, 0.0, {"address": 0x7A}),
        RangerSpec("left", "a02yyuw", "line", 0.0, 0.0, 0.0),
        RangerSpec("right", "maxbotix", "text", 0.0, 0.0, 0.0, {"model": "MB1240"}),
        RangerSpec("back", "urm15", "bus", 0.0, 0.0, 0.0),
    ]
    buses = {"ring": "i2c", "line": "serial", "text": "serial", "bus": "serial"}
    with served(short_dir, buses, rangers, WALL):
        yield short_dir


def test_i2c_rangers_are_found_by_their_registers_without_a_ping(
    robot: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    port = f"unix:{robot / 'ring.sock'}"
    assert main(["scan", port]) == 0
    assert capsys.readouterr().out.splitlines() == [port, "  0x71  srf08", "  0x7a  srf08"]


def test_asked_they_tell_what_they_see(robot: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scan", f"unix:{robot / 'ring.sock'}", "--ask"]) == 0
    assert capsys.readouterr().out.splitlines()[1:] == ["  0x71  srf08  1.500 m", "  0x7a  srf08  1.500 m"]


def test_a_ranger_that_talks_is_found_by_listening(robot: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scan", str(robot / "line"), "--json"]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    assert json.loads(line) == {
        "port": str(robot / "line"),
        "drivers": ["a02yyuw"],
        "address": None,
        "settings": {},
        "reading": "1.500 m",
    }


def test_of_a_maxbotix_it_is_told_which_model_was_assumed(
    robot: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["scan", str(robot / "text")]) == 0
    assert capsys.readouterr().out.splitlines()[1].startswith("  maxbotix (model MB1240?)  1.50")


def test_a_ranger_which_is_spoken_to_is_found_only_by_asking(
    robot: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["scan", str(robot / "bus")]) == 1
    assert main(["scan", str(robot / "bus"), "--ask"]) == 0
    assert "  0x0f  urm15  1.500 m" in capsys.readouterr().out.splitlines()


def test_a_line_that_was_heard_is_not_asked(robot: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scan", str(robot / "line"), "--ask"]) == 0
    told = capsys.readouterr()
    assert told.out.splitlines()[1:] == ["  a02yyuw  1.500 m"]
    assert "asking" not in told.err


def test_what_the_kernel_reads_is_told_by_its_driver(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    device = tmp_path / "iio:device0"
    device.mkdir()
    (device / "name").write_text("srf04\n")
    (device / "in_distance_raw").write_text("1500\n")
    (tmp_path / "iio:device1").mkdir()
    assert main(["scan", str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines()[1:] == ["  iio (device srf04?)"]


def test_a_port_that_is_not_there_is_told_and_the_others_are_scanned(
    robot: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["scan", "/dev/nothing", f"unix:{robot / 'ring.sock'}"]) == 0
    told = capsys.readouterr()
    assert "/dev/nothing: cannot open this serial port: it is not there" in told.err
    assert "  0x71  srf08" in told.out.splitlines()


def test_nothing_found_is_1(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scan", "/dev/nothing"]) == 1
