import os
import pty
import termios
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from errno import EACCES, EIO
from pathlib import Path

from pytest import fixture, mark, raises
from pytest_mock import MockerFixture
from serial.serialposix import TIOCCBRK, TIOCSBRK

from echogrid.drivers.bus import Break
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
    with raises(PortError, match=f"fuser -v {terminal.path}, and stop it"):
        SerialPort(terminal.path).open()


def test_a_forbidden_port_is_named_with_the_mend(terminal: Terminal, mocker: MockerFixture) -> None:
    mocker.patch("serial.serialposix.os.open", side_effect=OSError(EACCES, "Permission denied"))
    with raises(PortError, match=r"no permission \(sudo usermod -aG dialout \$USER"):
        SerialPort(terminal.path).open()


def test_a_path_that_is_no_terminal_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with raises(PortError, match="it is no serial port"):
        SerialPort(f"{tmp_path}/file").open()


def test_an_impossible_baud_rate_is_refused_by_name() -> None:
    with raises(ValueError, match="baud is 0: expected"):
        SerialPort("/dev/null", baud=0)


def control_flags(terminal: Terminal) -> int:
    """How the client has set the terminal."""
    return int(termios.tcgetattr(terminal.master)[2])


@mark.parametrize(("stop_bits", "expected"), [(1, 0), (2, termios.CSTOPB)])
def test_stop_bits_are_set(terminal: Terminal, stop_bits: int, expected: int) -> None:
    with closing(SerialPort(terminal.path, stop_bits=stop_bits)) as port:
        port.open()
        assert control_flags(terminal) & termios.CSTOPB == expected


def test_the_speed_is_set(terminal: Terminal) -> None:
    with closing(SerialPort(terminal.path, baud=19_200)) as port:
        port.open()
        assert termios.tcgetattr(terminal.master)[4:6] == [termios.B19200, termios.B19200]


@mark.parametrize(
    ("parity", "expected"),
    [("none", 0), ("even", termios.PARENB), ("odd", termios.PARENB | termios.PARODD)],
)
def test_parity_is_asked_for(terminal: Terminal, mocker: MockerFixture, parity: str, expected: int) -> None:
    set_attributes = mocker.spy(termios, "tcsetattr")  # a terminal that is none forgets its parity
    with closing(SerialPort(terminal.path, parity=parity)) as port:
        port.open()
    flags = set_attributes.call_args.args[2][2]
    assert flags & (termios.PARENB | termios.PARODD) == expected


def test_a_break_goes_out_behind_what_was_sent_and_lasts_as_long_as_it_should(
    port: SerialPort, mocker: MockerFixture
) -> None:
    done: list[object] = []
    names = {TIOCSBRK: "low", TIOCCBRK: "high"}
    mocker.patch(
        "serial.serialposix.fcntl.ioctl", side_effect=lambda fd, what, *_: done.append(names.get(what))
    )
    mocker.patch("serial.serialposix.termios.tcdrain", side_effect=lambda fd: done.append("drained"))
    mocker.patch("serial.serialposix.os.write", side_effect=lambda fd, data: done.append(data) or len(data))
    mocker.patch("echogrid.drivers.transports.serial.time.sleep", side_effect=done.append)
    port.write([b"before", Break(0.003), b"\x01\x51"])
    assert done == [b"before", "drained", "low", 0.003, "high", b"\x01\x51"]


def test_a_break_that_is_cut_short_does_not_leave_the_line_low(
    port: SerialPort, mocker: MockerFixture
) -> None:
    ioctl = mocker.patch("serial.serialposix.fcntl.ioctl")
    mocker.patch("echogrid.drivers.transports.serial.time.sleep", side_effect=KeyboardInterrupt)
    with raises(KeyboardInterrupt):
        port.write([Break(0.003)])
    assert ioctl.call_args.args[1] == TIOCCBRK


def test_a_break_on_a_lost_port_is_a_lost_port(port: SerialPort, terminal: Terminal) -> None:
    terminal.unplug()
    with raises(PortError, match="serial port lost"):
        port.write([Break(0.001)])


def test_an_adapter_that_can_is_told_to_hand_over_at_once(terminal: Terminal, mocker: MockerFixture) -> None:
    told = mocker.patch("serial.Serial.set_low_latency_mode")
    with closing(SerialPort(terminal.path)) as port:
        port.open()
    told.assert_called_once_with(True)


@mark.parametrize(
    ("key", "value", "expected"),
    [("stop_bits", 3, "1 to 2"), ("parity", "mark", "one of none, even, odd")],
)
def test_what_a_port_can_t_be_is_refused_by_name(key: str, value: object, expected: str) -> None:
    with raises(ValueError, match=f"{key} is {value!r}: expected {expected}"):
        SerialPort("/dev/null", **{key: value})  # type: ignore[arg-type] # the point of the test
