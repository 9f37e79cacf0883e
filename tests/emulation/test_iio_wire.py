"""The rangers of an emulated kernel, served to other processes as a socket."""

import socket
import threading
from collections.abc import Iterator
from errno import EINVAL, ENODEV
from pathlib import Path

from pytest import fixture, mark

from echogrid.drivers.clock import MonotonicClock
from echogrid.emulation.control import request
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RangerSpec, RobotSpec
from echogrid.emulation.scene import Echo
from echogrid.emulation.server import CONTROL_SOCKET, Server

LONG_S = 5.0
SPEC = RobotSpec(
    0.1,
    0.4,
    (BusSpec("pins", "iio"),),
    (
        RangerSpec("front", "iio", "pins", 0.0, 0.0, 0.0, {"device": "front"}),
        RangerSpec("rear", "iio", "pins", 0.0, 0.0, 0.0, {"device": "srf08"}),
    ),
    (),
)


@fixture
def directory(tmp_path: Path) -> Iterator[Path]:
    """A directory in which the robot is served by a thread."""
    air = Surroundings(lambda fire_ns: (Echo(1.5, 40.0, "wall"),), 343.5)
    robot = EmulatedRobot(SPEC, lambda ranger: air, lambda side: lambda now_ns: 0.0)
    stop = threading.Event()
    with Server(robot, tmp_path / "robot", MonotonicClock()) as server:
        thread = threading.Thread(target=server.run, args=(stop,))
        thread.start()
        try:
            yield tmp_path / "robot"
        finally:
            stop.set()
            thread.join()


def client(directory: Path) -> socket.socket:
    each = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    each.settimeout(LONG_S)
    each.connect(str(directory / "pins.sock"))
    return each


def ask(each: socket.socket, packet: bytes) -> tuple[int, bytes]:
    each.send(packet)
    reply = each.recv(65536)
    return int.from_bytes(reply[:4], "little", signed=True), reply[4:]


def test_files_are_read_by_device_and_name(directory: Path) -> None:
    with client(directory) as each:
        assert ask(each, b"front/name") == (0, b"srf04\n")
        assert ask(each, b"front/in_distance_raw") == (0, b"1500\n")
        assert ask(each, b"srf08/in_distance_raw") == (0, b"150\n")
        assert ask(each, b"rear/in_distance_raw") == (ENODEV, b"")


@mark.parametrize("packet", [b"front", b"/name", b"front/", b"\xff/name"])
def test_a_malformed_packet_is_refused_and_the_next_is_answered(directory: Path, packet: bytes) -> None:
    with client(directory) as each:
        assert ask(each, packet) == (EINVAL, b"")
        assert ask(each, b"front/name") == (0, b"srf04\n")


def test_two_clients_wait_for_each_other(directory: Path) -> None:
    with client(directory) as first, client(directory) as second:
        first.send(b"front/in_distance_raw")
        assert ask(second, b"srf08/in_distance_raw") == (0, b"150\n")
        assert first.recv(100)[4:] == b"1500\n"


def test_unplugged_the_socket_is_gone_and_comes_back(directory: Path) -> None:
    with client(directory) as each:
        request(directory / CONTROL_SOCKET, {"fault": "pins", "verb": "unplug"}, LONG_S)
        assert each.recv(100) == b""
    assert not (directory / "pins.sock").exists()
    request(directory / CONTROL_SOCKET, {"clear": "pins"}, LONG_S)
    with client(directory) as each:
        assert ask(each, b"front/in_distance_raw") == (0, b"1500\n")
