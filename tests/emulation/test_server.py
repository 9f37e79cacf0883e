import json
import os
import socket
import struct
import threading
from collections.abc import Iterator
from pathlib import Path

import can
import pytest
import serial

from echogrid.drivers.clock import MonotonicClock
from echogrid.emulation.control import request
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.errors import ControlError, DirectoryError
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RangerSpec, RobotSpec, WheelSpec
from echogrid.emulation.scene import Echo
from echogrid.emulation.server import CONTROL_SOCKET, Server, serve

MS = 1_000_000
FRAME = bytes.fromhex("FF05DCE0")
LONG_S = 5.0
SPEC = RobotSpec(
    0.1,
    0.4,
    (BusSpec("port", "serial"), BusSpec("can", "can"), BusSpec("i2c", "i2c")),
    (
        RangerSpec("left", "a02yyuw", "port", 0.0, 0.0, 0.0, {"period_ns": 20 * MS, "lag_ns": 0}),
        RangerSpec("front", "srf08", "i2c", 0.0, 0.0, 0.0),
    ),
    (WheelSpec("wheel", "odrive-0.5", "can", "left", {"node": 3}),),
)


def robot() -> EmulatedRobot:
    return EmulatedRobot(
        SPEC,
        lambda ranger: Surroundings(lambda fire_ns: (Echo(1.5, 20.0, "wall"),), 343.21),
        lambda _side: lambda _now_ns: 0.0,
    )


@pytest.fixture
def directory(tmp_path: Path) -> Iterator[Path]:
    """A directory in which a robot is served by a thread."""
    place = tmp_path / "robot"
    stop = threading.Event()
    with Server(robot(), place, MonotonicClock()) as server:
        thread = threading.Thread(target=server.run, args=(stop,))
        thread.start()
        try:
            yield place
        finally:
            stop.set()
            thread.join()


def control(directory: Path, **message: object) -> object:
    return request(directory / CONTROL_SOCKET, message, LONG_S)


def i2c_client(directory: Path) -> socket.socket:
    client = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    client.settimeout(LONG_S)
    client.connect(str(directory / "i2c.sock"))
    return client


def i2c(client: socket.socket, packet: bytes) -> tuple[int, bytes]:
    client.send(packet)
    reply = client.recv(65536)
    errno, length = struct.unpack_from("<iH", reply)
    assert length == len(reply) - 6
    return errno, reply[6:]


def read_registers(register: int, count: int, address: int = 0x70) -> bytes:
    write = struct.pack("<HHHB", address, 0, 1, register)
    return b"\x02" + write + struct.pack("<HHH", address, 1, count)


def slcan(directory: Path) -> can.BusABC:
    return can.Bus(
        interface="slcan", channel=str(directory / "can"), bitrate=500_000, sleep_after_open=0, timeout=0.1
    )


def next_frame(bus: can.BusABC, identifier: int) -> can.Message:
    while (message := bus.recv(LONG_S)) is not None:
        if message.arbitration_id == identifier:
            return message
    raise AssertionError("no such frame")


def test_pyserial_reads_the_sensors_frames(directory: Path) -> None:
    with serial.Serial(str(directory / "port"), 9600, timeout=LONG_S) as port:
        heard = port.read(12)
    assert FRAME + FRAME in heard


def test_at_the_wrong_speed_all_is_garbage(directory: Path) -> None:
    with serial.Serial(str(directory / "port"), 4800, timeout=LONG_S) as port:
        heard = port.read(40)
    assert len(heard) == 40
    assert FRAME not in heard


def test_a_client_that_does_not_read_blocks_nobody(directory: Path) -> None:
    idle = os.open(directory / "port", os.O_RDWR | os.O_NOCTTY)
    bus = slcan(directory)
    try:
        assert next_frame(bus, 0x069).data == bytes(8)
    finally:
        bus.shutdown()
        os.close(idle)


@pytest.mark.parametrize("name", ["left", "port"])
def test_an_unplugged_serial_port_hangs_up_and_comes_back_as_another_under_the_same_link(
    directory: Path, name: str
) -> None:
    link = directory / "port"
    before = link.readlink()
    with serial.Serial(str(link), 9600, timeout=LONG_S) as port:
        control(directory, fault=name, verb="unplug")
        assert not link.is_symlink()
        with pytest.raises((serial.SerialException, OSError)):
            while port.read(1):
                pass
    control(directory, clear=name)
    assert link.readlink() != before
    with serial.Serial(str(link), 9600, timeout=LONG_S) as port:
        assert FRAME in port.read(12)


def test_python_can_hears_heartbeats_and_gets_answers(directory: Path) -> None:
    bus = slcan(directory)
    try:
        assert len(next_frame(bus, 0x061).data) == 8
        bus.send(can.Message(arbitration_id=0x06A, is_extended_id=False, is_remote_frame=True, dlc=8))
        assert next_frame(bus, 0x06A).data == bytes(8)
    finally:
        bus.shutdown()


def test_a_can_adapter_that_comes_back_has_its_channel_closed(directory: Path) -> None:
    control(directory, fault="can", verb="unplug")
    assert not (directory / "can").is_symlink()
    control(directory, clear="can")
    with serial.Serial(str(directory / "can"), timeout=LONG_S) as port:
        port.write(b"t0010\rV\r")
        assert port.read(7) == b"\aV1013\r"


def test_an_i2c_client_pings_meets_a_nack_and_reads_an_echo(directory: Path) -> None:
    with i2c_client(directory) as client:
        ping = b"\x01" + struct.pack("<HHH", 0x70, 0, 2) + b"\x00\x51"
        assert i2c(client, ping) == (0, b"")
        errno, data = i2c(client, read_registers(2, 2))
        assert (errno, data) == (6, b"")
        while errno == 6:
            errno, data = i2c(client, read_registers(2, 2))
        assert (errno, data) == (0, b"\x00\x96")


@pytest.mark.parametrize("packet", [b"\x00", b"\x01", b"\x02" + struct.pack("<HHH", 0x70, 1, 1), b"\x01" * 8])
def test_a_malformed_i2c_packet_is_invalid(directory: Path, packet: bytes) -> None:
    with i2c_client(directory) as client:
        assert i2c(client, packet) == (22, b"")


def test_an_unplugged_i2c_adapter_takes_its_socket_away_and_brings_it_back(directory: Path) -> None:
    with i2c_client(directory) as client:
        control(directory, fault="i2c", verb="unplug")
        assert client.recv(16) == b""
        assert not (directory / "i2c.sock").exists()
    control(directory, clear="i2c")
    with i2c_client(directory) as client:
        assert i2c(client, read_registers(0, 1)) == (0, b"\x0a")


def test_faults_are_begun_listed_and_cleared_by_name(directory: Path) -> None:
    assert control(directory, fault="front", verb="off", for_s=None) is True
    control(directory, fault="left", verb="delayed", for_s=60.0)
    listed = control(directory, list=True)
    assert isinstance(listed, dict)
    left, front = listed["faults"]
    assert front == {"name": "front", "verb": "off", "for_s": None}
    assert (left["name"], left["verb"]) == ("left", "delayed")
    assert 0 < left["for_s"] <= 60.0
    assert set(listed["verbs"]["wheel"]) == {
        *("off", "unplug", "garbage", "delayed", "intermittent", "encoder_lost", "motor_failed", "slip")
    }
    control(directory, clear="front")
    with i2c_client(directory) as client:
        assert i2c(client, read_registers(0, 1))[0] == 0


@pytest.mark.parametrize(
    ("message", "error"),
    [
        ({"fault": "fron", "verb": "off"}, "did you mean 'front'"),
        ({"fault": "front", "verb": "melt"}, "address_conflict, delayed, garbage, intermittent"),
        ({"fault": "front", "verb": "off", "for_s": -1}, "for_s"),
        ({"clear": "nobody"}, "no device or bus 'nobody'"),
        ({"hello": 1}, "not understood"),
    ],
)
def test_a_message_that_cannot_be_done_is_answered_with_why(
    directory: Path, message: dict[str, object], error: str
) -> None:
    with pytest.raises(ControlError, match=error):
        control(directory, **message)


def test_the_control_socket_takes_many_lines_and_survives_nonsense(directory: Path) -> None:
    with socket.socket(socket.AF_UNIX) as client:
        client.settimeout(LONG_S)
        client.connect(str(directory / CONTROL_SOCKET))
        client.sendall(b'nonsense\n{"clear": "front"}\n')
        with client.makefile("rb") as stream:
            assert "not JSON" in json.loads(stream.readline())["error"]
            assert json.loads(stream.readline()) == {"ok": True}


def test_nobody_at_the_control_socket_is_told(tmp_path: Path) -> None:
    with pytest.raises(ControlError, match="start one with: echogrid emulate"):
        request(tmp_path / CONTROL_SOCKET, {"list": True})


def test_a_directory_in_which_an_emulator_lives_is_refused(directory: Path) -> None:
    with (
        pytest.raises(DirectoryError, match="another emulator"),
        Server(robot(), directory, MonotonicClock()),
    ):
        pass
    assert control(directory, clear="front") is True


def test_the_directory_is_private_and_goes_with_the_server(tmp_path: Path) -> None:
    place = tmp_path / "robot"
    with Server(robot(), place, MonotonicClock()):
        assert place.stat().st_mode & 0o777 == 0o700
        assert {entry.name for entry in place.iterdir()} == {"port", "can", "i2c.sock", CONTROL_SOCKET}
    assert not place.exists()


def test_what_a_dead_emulator_left_is_removed_and_the_rest_is_kept(tmp_path: Path) -> None:
    (tmp_path / "gone").symlink_to("/dev/pts/9999")
    (tmp_path / "notes").write_text("mine")
    with socket.socket(socket.AF_UNIX) as stale:
        stale.bind(str(tmp_path / CONTROL_SOCKET))
    with Server(robot(), tmp_path, MonotonicClock()):
        assert not (tmp_path / "gone").is_symlink()
    assert [entry.name for entry in tmp_path.iterdir()] == ["notes"]


def test_a_directory_too_deep_for_a_socket_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DirectoryError, match="too long"):
        serve(robot(), tmp_path / ("d" * 110), MonotonicClock(), threading.Event())
