"""The IIO ports: over a folder like the kernel's, and over a real socket."""

import os
import shutil
import socket
import threading
from collections.abc import Iterator
from contextlib import closing
from errno import EIO, EISDIR, ENODEV, ENOENT, ENOTUNIQ, EPROTO, ETIMEDOUT
from pathlib import Path
from struct import pack

from hypothesis import given
from hypothesis.strategies import binary
from pytest import fixture, mark, raises
from pytest_mock import MockerFixture

from echogrid.drivers.bus import IioRead
from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.iio import IioPort
from echogrid.drivers.transports.iio_socket import SocketAdapter, decode_reply, encode_request
from echogrid.drivers.transports.iio_sysfs import SysfsAdapter

RAW = "in_distance_raw"
LONG_S = 10.0


class Kernel:
    """A folder of IIO devices, as links to folders below what they hang on."""

    def __init__(self, root: Path) -> None:
        self.devices = root / "bus" / "iio" / "devices"
        self.devices.mkdir(parents=True)
        self._root = root

    def add(self, number: int, hangs_on: str, **files: str) -> Path:
        """A device; its folder."""
        folder = self._root / "devices" / hangs_on / f"iio:device{number}"
        folder.mkdir(parents=True)
        for name, text in files.items():
            (folder / name).write_text(text)
        (self.devices / folder.name).symlink_to(folder)
        return folder

    def remove(self, folder: Path) -> None:
        (self.devices / folder.name).unlink()
        shutil.rmtree(folder)


@fixture
def kernel(tmp_path: Path) -> Kernel:
    kernel = Kernel(tmp_path)
    kernel.add(0, "i2c-1/1-0076", name="bme280\n")
    kernel.add(1, "hc-sr04-front", name="srf04\n", label="front\n", in_distance_raw="1501\n")
    kernel.add(2, "hc-sr04-rear", name="srf04\n", label="rear\n", in_distance_raw="702\n")
    (kernel.devices / "trigger0").mkdir()
    (kernel.devices / "trigger0" / "name").write_text("front\n")
    return kernel


@fixture
def port(kernel: Kernel) -> Iterator[IioPort]:
    with closing(IioPort(SysfsAdapter(str(kernel.devices)))) as port:
        port.open()
        yield port


def result(port: IioPort, device: str, attribute: str = RAW) -> tuple[bytes, int]:
    port.write([IioRead(device, attribute)])
    (result,) = port.read(0.0)
    return result.data, result.errno


@mark.parametrize("device", ["iio:device2", "rear", "hc-sr04-rear"])
def test_a_device_is_found_by_its_folder_its_label_and_what_it_hangs_on(port: IioPort, device: str) -> None:
    assert result(port, device) == (b"702\n", 0)


def test_a_device_is_found_by_its_driver_if_no_other_has_the_same(port: IioPort) -> None:
    assert result(port, "bme280", "name") == (b"bme280\n", 0)
    assert result(port, "srf04") == (b"", ENOTUNIQ)


def test_a_device_that_is_not_there_and_a_file_that_it_lacks_are_told_apart(port: IioPort) -> None:
    assert result(port, "left") == (b"", ENODEV)
    assert result(port, "bme280") == (b"", ENOENT)


def test_results_come_in_order_with_the_times_of_their_reads(port: IioPort) -> None:
    port.write([IioRead("front", RAW), IioRead("rear", RAW), IioRead("left", RAW)])
    results = port.read(0.0)
    assert [result.transfer.device for result in results] == ["front", "rear", "left"]
    times = [time for result in results for time in (result.start_ns, result.end_ns)]
    assert times == sorted(times)
    assert list(port.read(0.0)) == []


def test_a_device_that_comes_back_under_another_number_is_found_again(kernel: Kernel, port: IioPort) -> None:
    folder = kernel.devices.joinpath("iio:device1").resolve()
    assert result(port, "front") == (b"1501\n", 0)
    kernel.remove(folder)
    assert result(port, "front") == (b"", ENODEV)
    kernel.add(7, "hc-sr04-front", name="srf04\n", label="front\n", in_distance_raw="1502\n")
    assert result(port, "front") == (b"1502\n", 0)


def test_an_error_of_the_kernel_is_a_result_and_the_next_read_goes_on(kernel: Kernel, port: IioPort) -> None:
    (kernel.devices / "iio:device0" / RAW).mkdir()
    assert result(port, "bme280") == (b"", EISDIR)
    assert result(port, "front") == (b"1501\n", 0)


def test_the_file_is_read_once_because_each_read_pings(port: IioPort, mocker: MockerFixture) -> None:
    assert result(port, "front", "name") == (b"srf04\n", 0)
    read = mocker.spy(os, "read")
    assert result(port, "front") == (b"1501\n", 0)
    assert read.call_count == 1


def test_a_read_that_blocks_is_waited_for_and_no_descriptor_is_left(kernel: Kernel, port: IioPort) -> None:
    slow = kernel.devices / "iio:device0" / RAW
    os.mkfifo(slow)
    before = len(list(Path("/proc/self/fd").iterdir()))
    writer = threading.Thread(target=slow.write_text, args=("250\n",))
    writer.start()
    assert result(port, "bme280") == (b"250\n", 0)
    writer.join(LONG_S)
    assert len(list(Path("/proc/self/fd").iterdir())) == before


def test_a_kernel_without_iio_is_named_with_the_mend(tmp_path: Path) -> None:
    with raises(
        PortError, match=f"{tmp_path}/none: cannot open this IIO port: it is not there .load .*dtoverlay"
    ):
        SysfsAdapter(f"{tmp_path}/none").open()


def test_a_folder_that_vanishes_is_a_lost_port(kernel: Kernel, port: IioPort) -> None:
    shutil.rmtree(kernel.devices)
    with raises(PortError, match="IIO port lost"):
        port.write([IioRead("front", RAW)])


def test_a_closed_port_reads_nothing(kernel: Kernel, port: IioPort) -> None:
    port.close()
    port.close()
    with raises(PortError, match="not open"):
        port.write([IioRead("front", RAW)])


class Server:
    """Answers each packet with the next of `answers`; None is no answer."""

    def __init__(self, path: Path) -> None:
        self.path = str(path)
        self.requests: list[bytes] = []
        self.answers: list[bytes | None] = []
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._listener.bind(self.path)
        self._listener.listen()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        with self._listener:
            while self._session():
                pass

    def _session(self) -> bool:
        client, _ = self._listener.accept()
        with client:
            while request := client.recv(1000):
                if request == b"stop":
                    return False
                self.requests.append(request)
                answer = self.answers.pop(0)
                if answer is not None:
                    client.send(answer)
        return True

    def stop(self) -> None:
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as client:
            client.connect(self.path)
            client.send(b"stop")
        self._thread.join(LONG_S)


@fixture
def server(tmp_path: Path) -> Iterator[Server]:
    server = Server(tmp_path / "pins.sock")
    yield server
    server.stop()


@fixture
def remote(server: Server) -> Iterator[IioPort]:
    with closing(IioPort(SocketAdapter(server.path))) as port:
        port.open()
        yield port


def test_a_read_crosses_the_socket_byte_by_byte_as_agreed(server: Server, remote: IioPort) -> None:
    server.answers = [bytes.fromhex("00000000") + b"1501\n", bytes.fromhex("05000000")]
    assert result(remote, "front") == (b"1501\n", 0)
    assert result(remote, "front") == (b"", EIO)
    assert server.requests == [b"front/in_distance_raw"] * 2


def test_an_emulator_that_does_not_answer_is_a_failed_read(server: Server) -> None:
    with closing(IioPort(SocketAdapter(server.path, 0.05))) as port:
        port.open()
        server.answers = [None, pack("<i", 0) + b"next\n"]
        assert result(port, "front") == (b"", ETIMEDOUT)
        assert result(port, "front") == (b"next\n", 0)


def test_a_missing_socket_is_named_with_the_mend(tmp_path: Path) -> None:
    with raises(PortError, match=f"{tmp_path}/none: cannot open this IIO socket port: it is not there"):
        SocketAdapter(f"{tmp_path}/none").open()


@given(binary(max_size=20))
def test_whatever_the_emulator_answers_is_a_text_or_an_error(packet: bytes) -> None:
    try:
        assert decode_reply(packet) == packet[4:]
    except OSError as error:
        assert error.errno == (int.from_bytes(packet[:4], "little", signed=True) if packet[3:] else EPROTO)


def test_a_request_names_device_and_file() -> None:
    assert encode_request(IioRead("iio:device0", "name")) == b"iio:device0/name"
