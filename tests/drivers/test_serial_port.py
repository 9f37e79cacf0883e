import os
import pty
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from errno import EACCES, EIO
from pathlib import Path

from pytest import fixture, raises
from pytest_mock import MockerFixture

from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.serial import SerialPort


@dataclass
class Terminal:
    master: int
    path: str

    def unplug(self) -> None:
        os.close(self.master)
        self.master = -1


@fixture
def terminal() -> Iterator[Terminal]:
    master, slave = pty.openpty()
    terminal = Terminal(master, os.ttyname(slave))
    os.close(slave)
    yield terminal
    if terminal.master >= 0:
        terminal.unplug()


@fixture
def port(terminal: Terminal) -> Iterator[SerialPort]:
    with closing(SerialPort(terminal.path)) as port:
        port.open()
        yield port


def test_bytes_come_in(terminal: Terminal, port: SerialPort) -> None:
    os.write(terminal.master, bytes.fromhex("FF07A1A7"))
    assert port.read(1.0) == (bytes.fromhex("FF07A1A7"),)


def test_bytes_go_out(terminal: Terminal, port: SerialPort) -> None:
    port.write([b"\x55", b"\x56"])
    assert os.read(terminal.master, 10) == b"\x55\x56"


def test_silence_is_nothing(port: SerialPort) -> None:
    assert port.read(0.0) == ()


def test_one_read_takes_a_bounded_part_of_a_flood(terminal: Terminal, port: SerialPort) -> None:
    sent = os.write(terminal.master, bytes(4000)) + os.write(terminal.master, bytes(4000))
    taken: list[int] = []
    while sum(taken) < sent and (chunks := port.read(1.0)):
        taken += map(len, chunks)
    assert sum(taken) == sent
    assert max(taken) <= 4096


def test_unplugging_is_a_lost_port_to_the_reader(terminal: Terminal, port: SerialPort) -> None:
    terminal.unplug()
    with raises(PortError, match=f"{terminal.path}: serial port lost, was it unplugged"):
        port.read(1.0)


def test_unplugging_is_a_lost_port_to_the_writer(terminal: Terminal, port: SerialPort) -> None:
    terminal.unplug()
    with raises(PortError, match="serial port lost"):
        port.write([b"x"])


def test_a_plain_os_error_is_a_lost_port(port: SerialPort, terminal: Terminal, mocker: MockerFixture) -> None:
    os.write(terminal.master, b"x")
    mocker.patch("serial.serialposix.fcntl.ioctl", side_effect=OSError(EIO, "gone"))
    with raises(PortError, match="serial port lost"):
        port.read(1.0)


def test_it_may_be_closed_twice_and_opened_again(terminal: Terminal, port: SerialPort) -> None:
    port.close()
    port.close()
    with raises(PortError, match="not open"):
        port.read(0.0)
    port.open()
    os.write(terminal.master, b"again")
    assert b"".join(port.read(1.0)) == b"again"


def test_a_missing_port_is_named_with_the_mend(tmp_path: Path) -> None:
    with raises(PortError, match=f"{tmp_path}/none: cannot open this serial port: .*plugged in"):
        SerialPort(f"{tmp_path}/none").open()


def test_a_port_in_use_is_named_with_the_mend(terminal: Terminal, port: SerialPort) -> None:
    with raises(PortError, match="another program holds it"):
        SerialPort(terminal.path).open()


def test_a_forbidden_port_is_named_with_the_mend(terminal: Terminal, mocker: MockerFixture) -> None:
    mocker.patch("serial.serialposix.os.open", side_effect=OSError(EACCES, "Permission denied"))
    with raises(PortError, match=r"no permission \(sudo usermod -aG dialout \$USER"):
        SerialPort(terminal.path).open()


def test_a_path_that_is_no_terminal_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with raises(PortError, match="Could not configure port"):
        SerialPort(f"{tmp_path}/file").open()


def test_an_impossible_baud_rate_is_refused_by_name() -> None:
    with raises(ValueError, match="baud is 0: expected"):
        SerialPort("/dev/null", baud=0)
