import socket
from contextlib import closing
from pathlib import Path

import pytest

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.device import Line
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.wires.memory import MemoryPort
from echogrid.runtime import assembly, outlets, robot_file
from echogrid.runtime.config import Config
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.errors import UsageError
from echogrid.runtime.obstacle_config import OutputConfig
from echogrid.runtime.pump import Pump

from .views import at

MS = 1_000_000
ROBOT = DEFAULT_ROBOT.read_text()
SOCKET = '[[output]]\ntype = "unix"\npath = "obstacles.sock"\n'
UDP = '[[output]]\ntype = "udp"\nhost = "127.0.0.1"\nport = 7654\nformat = "json"\n'
CAN = '[[output]]\ntype = "can"\nbus = "wheel_bus"\nid = 0x300\n'
LONE = '[[bus]]\nname = "spare"\nkind = "can"\nport = "can7"\n'


def configured(folder: Path, text: str) -> Config:
    (folder / "robot.toml").write_text(ROBOT + text)
    return robot_file.load(folder / "robot.toml")


def troubles(folder: Path, text: str) -> str:
    with pytest.raises(UsageError) as raised:
        configured(folder, text)
    return str(raised.value)


def test_each_table_is_an_output_by_its_own_name(tmp_path: Path) -> None:
    made = outlets.outputs(configured(tmp_path, SOCKET + UDP + CAN), tmp_path)
    assert [output.name for output in made] == [
        "unix:obstacles.sock",
        "udp:127.0.0.1:7654",
        "can:wheel_bus:0x300",
    ]


def test_a_path_starts_at_the_folder_of_the_file(tmp_path: Path) -> None:
    (made,) = outlets.outputs(configured(tmp_path, SOCKET), tmp_path)
    with (
        closing(made),
        closing(socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)) as bound,
    ):
        bound.bind(str(tmp_path / "obstacles.sock"))
        made.put(at(0))
    assert made.sent == 1


def beacon_lines(config: Config) -> dict[str, list[str]]:
    made = outlets.outputs(config, Path())
    lines, _ = assembly.parts(config, tuple(outlets.beacons(config, made)))
    return {line.name: [device.name for device in line.devices] for line in lines}


def test_an_output_on_a_bus_is_a_device_beside_the_wheels(tmp_path: Path) -> None:
    lines = beacon_lines(configured(tmp_path, CAN))
    assert lines["wheel_bus"] == ["left", "right", "can:wheel_bus:0x300"]


def test_a_bus_may_be_there_for_an_output_alone(tmp_path: Path) -> None:
    lines = beacon_lines(configured(tmp_path, LONE + CAN.replace("wheel_bus", "spare")))
    assert lines["spare"] == ["can:spare:0x300"]
    assert "spare" not in beacon_lines(configured(tmp_path, LONE))


def test_its_frames_are_on_the_bus_when_the_pump_has_turned(tmp_path: Path) -> None:
    config = configured(tmp_path, CAN)
    made = outlets.outputs(config, tmp_path)
    clock, bus = JumpingClock(), CanBus("wheel_bus", 500_000, [])
    heard: list[CanFrame] = []
    line: Line[CanFrame, CanFrame] = Line(
        "wheel_bus", [beacon for _, beacon in outlets.beacons(config, made)]
    )
    pump = Pump(line, Tap(MemoryPort(bus, clock), heard), clock, lambda _: None)
    pump.turn()
    for k in range(10):
        clock.sleep_until_ns((k + 1) * 20 * MS)
        made[0].put(at(clock.now_ns()))
        pump.turn()
    assert [frame.identifier for frame in heard] == [0x300, 0x301] * made[0].sent
    assert made[0].sent == 4


class Tap:
    """A port that also keeps what is sent."""

    def __init__(self, port: MemoryPort[CanFrame, CanFrame], heard: list[CanFrame]) -> None:
        self._port = port
        self._heard = heard
        self.open, self.close, self.read = port.open, port.close, port.read

    def write(self, items: tuple[CanFrame, ...]) -> None:
        self._heard += items
        self._port.write(items)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('[[output]]\ntype = "tcp"\n', "expected one of unix, udp, can, not 'tcp'"),
        ('[[output]]\ntype = "unix"\n', '`path` is needed for type = "unix"'),
        ('[[output]]\ntype = "udp"\nhost = "127.0.0.1"\n', "`port` is needed"),
        (SOCKET + "port = 5\n", '`port` is for type = "udp"'),
        (UDP.replace("127.0.0.1", "robot.local"), "`host` must be an IP address, not a name"),
        (UDP.replace("7654", "70000"), "`port` must lie in"),
        (CAN + 'format = "json"\n', '`format` is for type = "unix" and "udp"'),
        (CAN.replace("0x300", "0x1FFFFFFF"), "`id` must lie in"),
        (SOCKET + "rate_hz = 0\n", "`rate_hz` must lie in"),
        (SOCKET + "rat_hz = 1\n", "unknown key `rat_hz` (did you mean `rate_hz`?)"),
        (CAN.replace("wheel_bus", "wheels_bus"), "no [[bus]] named 'wheels_bus' (did you mean `wheel_bus`?)"),
        (CAN.replace("wheel_bus", "ring_bus"), "bus 'ring_bus' is no CAN bus"),
        (SOCKET + SOCKET, "a second [[output]] to unix:obstacles.sock"),
        (
            LONE + "listen_only = true\n" + CAN.replace("wheel_bus", "spare"),
            "listen_only = true: nothing can be told",
        ),
    ],
)
def test_what_is_wrong_is_told_with_its_line(tmp_path: Path, text: str, why: str) -> None:
    told = troubles(tmp_path, text)
    assert why in told
    assert "robot.toml:" in told
    assert "output[" in told


def test_the_label_needs_no_place_of_another_type() -> None:
    assert OutputConfig("can", bus="b", id=0).label == "can:b:0x0"
