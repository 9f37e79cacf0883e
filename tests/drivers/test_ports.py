import os
import pty
import socket
import subprocess
import sys
from contextlib import closing
from pathlib import Path

from pytest import mark, raises

from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.can import CanPort
from echogrid.drivers.transports.i2c import I2cPort
from echogrid.drivers.transports.ports import make_port, open_port
from echogrid.drivers.transports.serial import SerialPort


@mark.parametrize(
    ("kind", "address", "options", "made"),
    [
        ("serial", "/dev/ttyUSB0", {"baud": 19200}, SerialPort),
        ("i2c", "/dev/i2c-1", {}, I2cPort),
        ("i2c", "unix:/run/bus", {"timeout_s": 0.2}, I2cPort),
        (
            "can",
            "can0",
            {"interface": "socketcan", "bitrate": 500_000, "receive_own_messages": False},
            CanPort,
        ),
    ],
)
def test_a_port_is_made_by_kind(kind: str, address: str, options: dict[str, object], made: type) -> None:
    assert isinstance(make_port(kind, address, options), made)


@mark.parametrize(
    ("kind", "options", "text"),
    [
        ("spi", {}, "kind is 'spi': expected 'serial', 'i2c', 'can' or 'iio'"),
        ("serial", {"bitrate": 1}, "bitrate is no option of this port: expected baud"),
        ("i2c", {"timeout": 1}, "timeout is no option of this port: expected timeout_s"),
        ("i2c", {"timeout_s": 0}, "timeout_s is 0: expected 0.01 to 10.0"),
        ("serial", {"baud": -1}, "baud is -1: expected"),
    ],
)
def test_an_impossible_port_is_refused_by_name(kind: str, options: dict[str, object], text: str) -> None:
    with raises(ValueError, match=text):
        make_port(kind, "/dev/null", options)


@mark.parametrize("address", ["unix:/nowhere/bus", "/nowhere/i2c-1"])
def test_an_i2c_port_goes_where_its_address_says(address: str) -> None:
    with raises(PortError, match=f"^{address.removeprefix('unix:')}: "):
        open_port("i2c", address)


@mark.parametrize(
    ("kind", "options", "place", "text"),
    [
        ("serial", {}, "folder", "it is a folder"),
        ("serial", {}, "file", "it is no serial port"),
        ("serial", {}, "/dev/null", "it is no serial port"),
        ("serial", {}, "socket", "it is no serial port"),
        ("i2c", {}, "folder", "it is a folder"),
        ("i2c", {}, "file", "it is no I2C bus"),
        ("i2c", {}, "terminal", "it is no I2C bus"),
        ("i2c", {}, "socket", "it is a socket: write unix:{}"),
        ("iio", {}, "socket", "it is a socket: write unix:{}"),
        ("can", {"interface": "slcan"}, "folder", "it is a folder"),
        ("can", {"interface": "slcan"}, "/dev/null", "it is no serial port"),
        ("can", {}, "terminal", 'it is a serial port: say interface = "slcan"'),
    ],
)
def test_what_stands_in_the_place_of_a_port_is_told(
    kind: str, options: dict[str, object], place: str, text: str, tmp_path: Path
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    master, slave = pty.openpty()
    (tmp_path / "terminal").symlink_to(os.ttyname(slave))
    path = tmp_path / place
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as listener:
        listener.bind(str(tmp_path / "socket"))
        with raises(PortError) as told:
            open_port(kind, str(path), options)
    os.close(slave)
    os.close(master)
    assert str(told.value).startswith(f"{path}: ")
    assert str(told.value).endswith(f": {text.format(path)}")


def test_an_opened_port_can_be_read() -> None:
    master, slave = pty.openpty()
    os.write(master, b"")
    with closing(open_port("serial", os.ttyname(slave))) as port:
        os.write(master, b"x")
        assert port.read(5.0) == (b"x",)
    os.close(slave)
    os.close(master)


def test_no_library_is_imported_before_a_port_is_opened() -> None:
    program = (
        "import sys, echogrid.drivers.transports.ports as ports, echogrid.drivers.registry\n"
        "for kind in ('can', 'i2c', 'serial'): ports.make_port(kind, 'nowhere')\n"
        "print(sorted({'can', 'serial', 'smbus2'} & set(sys.modules)))"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"
