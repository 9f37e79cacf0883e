"""The I2C ports: over a real socket, and at the edge of the kernel."""

import os
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from errno import EACCES, EBUSY, ENODEV, ENXIO, EOPNOTSUPP, EPROTO, ETIMEDOUT
from pathlib import Path
from struct import pack
from typing import Any

from pytest import fixture, mark, raises
from pytest_mock import MockerFixture

from echogrid.drivers.bus import I2cMessage, I2cTransfer
from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.i2c import I2cPort
from echogrid.drivers.transports.i2c_kernel import KernelAdapter
from echogrid.drivers.transports.i2c_socket import SocketAdapter

POINTER = I2cTransfer((I2cMessage(0x70, write=b"\x00"),))
READ = I2cTransfer((I2cMessage(0x70, read=4),))
BOTH = I2cTransfer((I2cMessage(0x70, write=b"\x02"), I2cMessage(0x71, read=2)))

Answer = Callable[[bytes], bytes | None]


class Server:
    """Answers requests on a socket as told; None is no answer, b"" hangs up."""

    def __init__(self, path: Path) -> None:
        self.path = str(path)
        self.answers: list[bytes | None] = []
        self.requests: list[bytes] = []
        self.accepted = 0
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._listener.bind(self.path)
        self._listener.listen()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        with self._listener:
            while self._session(self._listener.accept()[0]):
                self.accepted += 1

    def _session(self, client: socket.socket) -> bool:
        with client:
            while request := client.recv(1000):
                if request == b"stop":
                    return False
                self.requests.append(request)
                answer = self.answers.pop(0)
                if answer == b"":
                    return True
                if answer is not None:
                    client.send(answer)
        return True

    def stop(self) -> None:
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as client:
            client.connect(self.path)
            client.send(b"stop")
        self._thread.join(5.0)


@fixture
def server(tmp_path: Path) -> Iterator[Server]:
    server = Server(tmp_path / "bus")
    yield server
    server.stop()


@fixture
def port(server: Server) -> Iterator[I2cPort]:
    with closing(I2cPort(SocketAdapter(server.path, 5.0))) as port:
        port.open()
        yield port


def reply(data: bytes = b"", errno: int = 0) -> bytes:
    return pack("<iH", errno, len(data)) + data


def test_a_transfer_crosses_the_socket_byte_by_byte_as_agreed(server: Server, port: I2cPort) -> None:
    server.answers = [reply(b"\x12\x34")]
    port.write([BOTH])
    (result,) = port.read(0.0)
    assert server.requests == [bytes.fromhex("02  7000 0000 0100 02  7100 0100 0200")]
    assert (result.transfer, result.data, result.errno) == (BOTH, b"\x12\x34", 0)
    assert 0 < result.start_ns <= result.end_ns


def test_results_come_in_the_order_of_the_transfers_and_once(server: Server, port: I2cPort) -> None:
    server.answers = [reply(), reply(b"\x09\x80\x00\x00")]
    port.write([POINTER, READ])
    assert [result.transfer for result in port.read(0.0)] == [POINTER, READ]
    assert list(port.read(0.0)) == []


def test_a_failed_transfer_is_a_result_and_the_next_goes_on(server: Server, port: I2cPort) -> None:
    server.answers = [reply(errno=ENXIO), reply()]
    port.write([READ, POINTER])
    assert [(result.errno, result.data) for result in port.read(0.0)] == [(ENXIO, b""), (0, b"")]


@mark.parametrize("malformed", [b"\x00", reply(b"abc")[:-1]])
def test_a_malformed_reply_is_a_failed_transfer(server: Server, port: I2cPort, malformed: bytes) -> None:
    server.answers = [malformed]
    port.write([READ])
    assert port.read(0.0)[0].errno == EPROTO


def test_a_late_reply_is_a_failed_transfer_and_not_taken_for_the_next(server: Server) -> None:
    with closing(I2cPort(SocketAdapter(server.path, 0.05))) as port:
        port.open()
        server.answers = [None, reply(b"next")]
        port.write([READ, READ])
        assert [(result.errno, result.data) for result in port.read(0.0)] == [(ETIMEDOUT, b""), (0, b"next")]


def test_an_emulator_that_hangs_up_is_a_lost_port(server: Server, port: I2cPort) -> None:
    server.answers = [b""]
    with raises(PortError, match=f"{server.path}: I2C socket lost, did the emulator stop"):
        port.write([READ])
    with raises(PortError, match="I2C socket lost"):
        port.write([READ])


def test_reopening_forgets_old_results(server: Server, port: I2cPort) -> None:
    server.answers = [reply()]
    port.write([POINTER])
    port.open()
    assert list(port.read(0.0)) == []


def test_it_may_be_closed_twice(port: I2cPort) -> None:
    port.close()
    port.close()
    with raises(PortError, match="not open"):
        port.write([READ])


def test_a_missing_socket_is_named_with_the_mend(tmp_path: Path) -> None:
    with raises(PortError, match=f"{tmp_path}/none: cannot open this I2C socket port: it is not there"):
        SocketAdapter(f"{tmp_path}/none", 0.1).open()


def test_a_socket_that_nobody_serves_is_named_with_the_mend(tmp_path: Path) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as deserted:
        deserted.bind(f"{tmp_path}/bus")
    with raises(PortError, match="is the emulator running"):
        SocketAdapter(f"{tmp_path}/bus", 0.1).open()


class Kernel:
    """Stands in for the ioctl of /dev/i2c-N."""

    def __init__(self, mocker: MockerFixture) -> None:
        self.errno = 0
        self.messages: list[tuple[int, int, bytes]] = []
        self.timeouts: list[int] = []
        mocker.patch("smbus2.smbus2.ioctl", self._ioctl)
        mocker.patch("echogrid.drivers.transports.i2c_kernel.ioctl", self._set)

    def _set(self, descriptor: int, request: int, value: int) -> None:
        self.timeouts.append(value)

    def _ioctl(self, descriptor: int, request: int, argument: Any) -> None:
        if request != 0x0707:
            return
        if self.errno:
            raise OSError(self.errno, os.strerror(self.errno))
        for message in argument.msgs[: argument.nmsgs]:
            if message.flags:
                message.buf[0] = b"\x09"
            self.messages.append((message.addr, message.flags, bytes(message)))


@fixture
def kernel(mocker: MockerFixture) -> Kernel:
    return Kernel(mocker)


@fixture
def adapter(kernel: Kernel, tmp_path: Path) -> Iterator[I2cPort]:
    (tmp_path / "i2c-1").touch()
    with closing(I2cPort(KernelAdapter(f"{tmp_path}/i2c-1", 0.1))) as port:
        port.open()
        yield port


def test_the_kernel_is_given_whole_transfers_and_a_bounded_time(kernel: Kernel, adapter: I2cPort) -> None:
    adapter.write([BOTH])
    assert kernel.messages == [(0x70, 0, b"\x02"), (0x71, 1, b"\x09\x00")]
    assert kernel.timeouts == [10]
    assert adapter.read(0.0)[0].data == b"\x09\x00"


def test_a_missing_acknowledge_is_a_result(kernel: Kernel, adapter: I2cPort) -> None:
    kernel.errno = ENXIO
    adapter.write([READ])
    assert adapter.read(0.0)[0].errno == ENXIO


@mark.parametrize(("errno", "text"), [(ENODEV, "I2C adapter lost"), (EOPNOTSUPP, "not an adapter for plain")])
def test_an_adapter_that_is_gone_or_unable_is_a_lost_port(
    kernel: Kernel, adapter: I2cPort, errno: int, text: str
) -> None:
    kernel.errno = errno
    with raises(PortError, match=text):
        adapter.write([READ])


@mark.parametrize(
    ("errno", "mend"),
    [(EACCES, r"sudo usermod -aG i2c \$USER"), (EBUSY, "another program"), (ENODEV, "plugged in")],
)
def test_an_adapter_that_does_not_open_is_named_with_the_mend(
    mocker: MockerFixture, errno: int, mend: str
) -> None:
    mocker.patch("smbus2.smbus2.os.open", side_effect=OSError(errno, os.strerror(errno)))
    with raises(PortError, match=f"/dev/i2c-7: cannot open this I2C port: .*{mend}"):
        KernelAdapter("/dev/i2c-7", 0.1).open()


def test_a_closed_adapter_is_no_port(tmp_path: Path) -> None:
    with raises(PortError, match="not open"):
        KernelAdapter(f"{tmp_path}/i2c-1", 0.1).transfer(READ)
