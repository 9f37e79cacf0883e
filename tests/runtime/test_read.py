import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from echogrid.drivers.device import Health, State
from echogrid.emulation.robot import RangerSpec
from echogrid.runtime.acquisition import DeviceReport
from echogrid.runtime.command_line import main
from echogrid.runtime.commands.read import HealthNews

from .served import served

WALL = 1.5
ROBOT = """
[[bus]]
name = "ring"
kind = "i2c"
port = "unix:ring.sock"

[[bus]]
name = "line"
kind = "serial"
port = "line"

[[sensor]]
name = "front"
driver = "srf08"
bus = "ring"
address = 0x71
x_m = 0.1
y_m = 0.0
yaw_deg = 0.0
half_angle_deg = 15.0
min_m = 0.05
max_m = 3.0

[[sensor]]
name = "left"
driver = "a02yyuw"
bus = "line"
x_m = 0.1
y_m = 0.0
yaw_deg = 90.0
half_angle_deg = 15.0
min_m = 0.05
max_m = 3.0
"""


@pytest.fixture
def robot(short_dir: Path) -> Iterator[Path]:
    """The folder of a robot with two rangers, and its robot.toml."""
    rangers = [
        RangerSpec("front", "srf08", "ring", 0.0, 0.0, 0.0, {"address": 0x71}),
        RangerSpec("left", "a02yyuw", "line", 0.0, 0.0, 0.0),
    ]
    with served(short_dir, {"ring": "i2c", "line": "serial"}, rangers, WALL):
        (short_dir / "robot.toml").write_text(ROBOT)
        yield short_dir
        (short_dir / "robot.toml").unlink()


@pytest.mark.parametrize("sensor", ["front", "left"])
def test_a_sensor_of_the_robot_is_read_by_its_name(
    robot: Path, sensor: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["read", sensor, "--dir", str(robot), "--count", "2", "--duration", "10s"]) == 0
    told = capsys.readouterr()
    lines = told.out.splitlines()
    assert len(lines) == 2
    assert all(sensor in line and "1.500 m" in line for line in lines)
    assert lines[0].split()[0] == "0.000"
    assert all(float(line.split()[0]) >= 0.0 for line in lines)
    assert f"{sensor}: well: ranging" in told.err


def test_json_has_a_line_for_each_reading_with_its_raw_bytes(
    robot: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["read", "left", "--robot", str(robot / "robot.toml"), "--json", "--count", "1"]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    reading = json.loads(line)
    assert reading["outcome"] == "echo"
    assert reading["distance_m"] == WALL
    assert reading["raw"] == "ff05dce0"


def test_a_driver_on_a_port_needs_no_robot(robot: Path, capsys: pytest.CaptureFixture[str]) -> None:
    port = f"unix:{robot / 'ring.sock'}"
    assert main(["read", "srf08", "--port", port, "--set", "address=0x71", "--count", "1"]) == 0
    assert "1.500 m" in capsys.readouterr().out


def test_nobody_at_the_address_is_told_with_the_mend_and_exit_1(
    robot: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    port = f"unix:{robot / 'ring.sock'}"
    assert main(["read", "srf08", "--port", port, "--duration", "500ms"]) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert "srf08: missing: no answer at 0x70 (7 bit): check its power, wires and address" in told.err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["nobody"], "no emulated robot runs in"),
        (["srf8", "--port", "x"], "unknown driver 'srf8' (did you mean 'srf08'?)"),
        (["srf08", "--port", "x", "--set", "adress=1"], "unknown key `adress` (did you mean `address`?)"),
        (["srf08", "--port", "x", "--set", "address=foo"], "address: expected a whole number, not 'foo'"),
        (["srf08", "--port", "x", "--set", "address=300"], "address is 0x12c: expected 0x70 to 0x7f"),
        (["front", "--set", "address=1"], "--set goes with --port"),
        (["front", "--count", "0"], "'0' is no count"),
        (["srf08", "--port", "x", "--set", "address"], "'address' is no setting"),
    ],
)
def test_misuse_is_2_with_the_mend(
    arguments: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["read", *arguments, "--dir", str(tmp_path)]) == 2
    assert told in capsys.readouterr().err


def test_a_name_that_the_robot_has_not_is_told_with_the_nearest(
    robot: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["read", "frond", "--dir", str(robot)]) == 2
    told = capsys.readouterr().err
    assert "no [[sensor]], [[wheel]] or [[gyro]] named 'frond' (did you mean `front`?)" in told


def test_a_port_that_is_not_there_is_1_with_the_mend(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["read", "a02yyuw", "--port", "/dev/nothing", "--count", "1"]) == 1
    assert "/dev/nothing: cannot open this serial port: it is not there" in capsys.readouterr().err


def told_at(looks: list[tuple[float, State, str]]) -> list[float]:
    """The times (s) of those looks at a device's health of which something is told."""
    news = HealthNews()
    reports = [(at_s, DeviceReport("d", "bus", Health(state, text, {}))) for at_s, state, text in looks]
    return [at_s for at_s, report in reports if news.line(report, round(at_s * 1e9)) is not None]


def test_texts_that_take_turns_in_one_state_are_told_once_a_second() -> None:
    looks = [(k / 5, State.FAULTY, f"code {k % 2 or k}") for k in range(20)]
    assert told_at(looks) == [0.0, 1.0, 2.0, 3.0]


def test_states_that_take_turns_are_told_once_a_second_each() -> None:
    looks = [(k / 10, (State.WELL, State.GARBLED)[k % 2], "so") for k in range(40)]
    assert len(told_at(looks)) <= 8


def test_a_new_state_is_told_at_once_and_the_same_again_is_not() -> None:
    looks = [(0.0, State.SETTING_UP, ""), (0.1, State.MISSING, "a"), (5.0, State.MISSING, "a")]
    assert told_at([*looks, (5.2, State.WELL, "")]) == [0.0, 0.1, 5.2]
