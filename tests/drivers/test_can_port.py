"""The CAN port: slcan over a real pty, python-can's buses in this process and between processes."""

import os
import pty
import select
import socket
import time
from collections.abc import Iterator
from contextlib import closing
from errno import EACCES, ENETDOWN, ENOBUFS, ENXIO
from pathlib import Path

import can
import pytest
from pytest import CaptureFixture, LogCaptureFixture, fixture, mark, raises
from pytest_mock import MockerFixture

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import Health, State
from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.can import CanPort
from echogrid.drivers.transports.can_link import BusState, CanLink

MS = 1_000_000


class Adapter:
    """An slcan adapter's end of a pty."""

    def __init__(self) -> None:
        self.master, slave = pty.openpty()
        self.path = os.ttyname(slave)
        os.close(slave)

    def say(self, text: bytes) -> None:
        os.write(self.master, text)

    def heard(self, ending: bytes) -> bytes:
        """All that was sent to it, up to the ending."""
        text = b""
        while not text.endswith(ending) and select.select([self.master], [], [], 5.0)[0]:
            text += os.read(self.master, 1000)
        return text

    def heard_nothing(self) -> bool:
        return not select.select([self.master], [], [], 0.05)[0]

    def unplug(self) -> None:
        if self.master >= 0:
            os.close(self.master)
            self.master = -1


@fixture
def adapter() -> Iterator[Adapter]:
    adapter = Adapter()
    yield adapter
    adapter.unplug()


@fixture
def port(adapter: Adapter) -> Iterator[CanPort]:
    with closing(CanPort(adapter.path, interface="slcan")) as port:
        port.open()
        yield port


def read(port: CanPort, count: int) -> list[CanFrame]:
    """That many frames, or fewer if they do not come."""
    frames: list[CanFrame] = []
    give_up = time.monotonic() + 5.0
    while len(frames) < count and time.monotonic() < give_up:
        frames += port.read(1.0)
    return frames


def test_the_adapter_is_opened_at_the_bit_rate(adapter: Adapter, port: CanPort) -> None:
    assert adapter.heard(b"O\rO\r") == b"C\rS5\r\rO\rO\r"


def test_a_frame_comes_in_with_its_stamp(adapter: Adapter, port: CanPort) -> None:
    before_ns = time.monotonic_ns()
    adapter.say(b"t06980000C03F000010C0\r")
    (frame,) = read(port, 1)
    assert frame.identifier == 0x069
    assert frame.data == bytes.fromhex("0000C03F000010C0")
    assert before_ns <= frame.stamp_ns <= time.monotonic_ns()


def test_extended_and_remote_frames_are_marked(adapter: Adapter, port: CanPort) -> None:
    adapter.say(b"T0000090980000138800640032\rr0698\r")
    extended, remote = read(port, 2)
    assert (extended.identifier, extended.extended, extended.remote) == (0x909, True, False)
    assert (remote.identifier, remote.extended, remote.remote, remote.data) == (0x069, False, True, b"")


def test_one_read_takes_all_that_is_pending(adapter: Adapter, port: CanPort) -> None:
    adapter.say(b"".join(b"t0011%02X\r" % n for n in range(50)))
    assert [frame.data[0] for frame in read(port, 50)] == list(range(50))


@mark.parametrize(
    "line",
    [b"tXYZ20102\r", b"t0\r", b"t1\r", b"T01\r", b"t001401\r", b"t0019010203040506070809\r", b"t0012ZZ\r"],
)
def test_a_malformed_line_is_counted_and_the_next_frame_comes(
    adapter: Adapter, port: CanPort, line: bytes
) -> None:
    adapter.say(line + b"t0012AABB\r")
    (frame,) = read(port, 1)
    assert (frame.identifier, frame.data) == (0x001, b"\xaa\xbb")
    assert port.counts.total() == 1


def test_bytes_that_are_no_text_are_counted_and_later_frames_come(adapter: Adapter, port: CanPort) -> None:
    adapter.say(b"t0012\xff\xfe\r")
    while not port.counts:
        port.read(5.0)
    adapter.say(b"t0012AABB\r")
    assert [frame.data for frame in read(port, 1)] == [b"\xaa\xbb"]
    assert port.counts == {"malformed lines": 1}


def test_silence_is_nothing(port: CanPort) -> None:
    assert list(port.read(0.0)) == []


def test_frames_go_out(adapter: Adapter, port: CanPort) -> None:
    adapter.heard(b"O\rO\r")
    port.write([CanFrame(0x069, b"\x01\x02"), CanFrame(0x12345, b"", extended=True)])
    assert adapter.heard(b"T000123450\r") == b"t06920102\rT000123450\r"


def test_a_port_that_may_only_listen_sends_nothing_and_counts_it(adapter: Adapter) -> None:
    with closing(CanPort(adapter.path, interface="slcan", listen_only=True)) as port:
        port.open()
        adapter.heard(b"O\rO\r")
        port.write((CanFrame(0x123, b"\x01"), CanFrame(0x124, b"")))
        assert port.counts["frames not to be sent"] == 2
        assert adapter.heard_nothing()
        adapter.say(b"t0011AA\r")
        assert [frame.identifier for frame in port.read(1.0)] == [1]


def test_unplugging_is_a_lost_port_and_nothing_is_printed(
    adapter: Adapter, capfd: CaptureFixture[str], caplog: LogCaptureFixture
) -> None:
    port = CanPort(adapter.path, interface="slcan")
    port.open()
    adapter.unplug()
    with raises(PortError, match=f"{adapter.path}: CAN port lost, was it unplugged"):
        port.read(1.0)
    with raises(PortError, match="CAN port lost"):
        port.write([CanFrame(1, b"")])
    port.close()
    port.close()
    del port
    assert capfd.readouterr() == ("", "")
    assert caplog.records == []


def test_a_closed_port_is_no_port(port: CanPort) -> None:
    port.close()
    with raises(PortError, match="not open"):
        port.read(0.0)


def test_it_can_be_opened_again(adapter: Adapter, port: CanPort) -> None:
    port.open()
    adapter.say(b"t0012AABB\r")
    assert len(read(port, 1)) == 1


def test_a_missing_adapter_is_named_with_the_mend(tmp_path: Path) -> None:
    with raises(PortError, match=f"{tmp_path}/none: cannot open this CAN port: .*plugged in"):
        CanPort(f"{tmp_path}/none", interface="slcan").open()


def test_a_forbidden_adapter_is_named_with_the_mend(adapter: Adapter, mocker: MockerFixture) -> None:
    mocker.patch("serial.serialposix.os.open", side_effect=OSError(EACCES, "Permission denied"))
    with raises(PortError, match=r"sudo usermod -aG dialout \$USER"):
        CanPort(adapter.path, interface="slcan").open()


@mark.parametrize("options", [{"interface": "no_such_interface"}, {"interface": "slcan", "bitrate": 333_333}])
def test_what_python_can_refuses_is_a_port_error(adapter: Adapter, options: dict[str, object]) -> None:
    with raises(PortError, match="cannot open this CAN port"):
        CanPort(adapter.path, **options).open()  # type: ignore[arg-type] # the point of the test


def test_an_impossible_bit_rate_is_refused_by_name() -> None:
    with raises(ValueError, match="bitrate is 0: expected"):
        CanPort("can0", bitrate=0)


@fixture
def peer() -> Iterator[can.BusABC]:
    with can.Bus(channel="test", interface="virtual", ignore_config=True) as peer:
        yield peer


@fixture
def virtual(peer: can.BusABC) -> Iterator[CanPort]:
    with closing(CanPort("test", interface="virtual")) as port:
        port.open()
        yield port


def test_an_interface_without_a_descriptor_works_alike(peer: can.BusABC, virtual: CanPort) -> None:
    peer.send(can.Message(arbitration_id=0x021, data=bytes(8), is_extended_id=False))
    assert [(frame.identifier, frame.data) for frame in read(virtual, 1)] == [(0x021, bytes(8))]


def test_error_frames_and_fd_frames_are_counted(peer: can.BusABC, virtual: CanPort) -> None:
    peer.send(can.Message(arbitration_id=0x004, is_error_frame=True, data=bytes(8)))
    peer.send(can.Message(arbitration_id=0x021, is_fd=True, data=bytes(12), is_extended_id=False))
    peer.send(can.Message(arbitration_id=0x021, data=b"", is_extended_id=False))
    assert len(read(virtual, 1)) == 1
    assert virtual.counts == {"error frames": 1, "malformed frames": 1}


def test_an_interface_that_goes_down_is_a_lost_port(virtual: CanPort, mocker: MockerFixture) -> None:
    down = can.CanOperationError("Network is down", ENETDOWN)
    mocker.patch("can.interfaces.virtual.VirtualBus.recv", side_effect=down)
    with raises(PortError, match=r"test: CAN port lost, was it unplugged or set down\? \(Network is down"):
        virtual.read(0.0)


def test_a_frame_of_the_kernel_keeps_the_time_when_it_came(mocker: MockerFixture) -> None:
    before_ns, wall_s, after_ns = time.monotonic_ns(), time.time(), time.monotonic_ns()
    sent = can.Message(arbitration_id=0x021, data=bytes(8), is_extended_id=False, timestamp=wall_s)
    bus = mocker.Mock(**{"recv.side_effect": [sent, None], "fileno.side_effect": NotImplementedError})
    mocker.patch("can.Bus", return_value=bus)
    port = CanPort("can0", interface="socketcan")
    port.open()
    (frame,) = port.read(0.0)
    assert before_ns - 1_000_000 <= frame.stamp_ns <= after_ns + 1_000_000


def test_frames_go_out_by_an_interface_without_a_descriptor(peer: can.BusABC, virtual: CanPort) -> None:
    virtual.write([CanFrame(0x021, b"\x01"), CanFrame(0x12345, b"", extended=True, remote=True)])
    first, second = peer.recv(1.0), peer.recv(1.0)
    assert first and second
    assert (first.arbitration_id, bytes(first.data), first.is_extended_id) == (0x021, b"\x01", False)
    assert (second.arbitration_id, second.is_remote_frame) == (0x12345, True)


@fixture
def multicast() -> Iterator[tuple[CanPort, CanPort]]:
    """Two ports of one group, on a UDP port of this process's own."""
    pytest.importorskip("msgpack", reason="udp_multicast needs msgpack")
    more = {"port": 20_000 + os.getpid() % 20_000, "hop_limit": 0}
    ports = (
        CanPort("239.74.163.2", interface="udp_multicast", more=more),
        CanPort("239.74.163.2", interface="udp_multicast", more=more),
    )
    with closing(ports[0]), closing(ports[1]):
        try:
            for port in ports:
                port.open()
            ports[0].write([CanFrame(0x7FF, b"")])
        except PortError as error:
            pytest.skip(f"no multicast on this machine: {error}")
        if not read(ports[1], 1):
            pytest.skip("multicast does not come back to this machine")
        yield ports


def test_frames_cross_by_udp_multicast_and_nobody_hears_itself(multicast: tuple[CanPort, CanPort]) -> None:
    one, other = multicast
    before_ns = time.monotonic_ns()
    one.write([CanFrame(0x021, b"\x01\x02"), CanFrame(0x12345, b"", extended=True)])
    frames = read(other, 2)
    assert [(frame.identifier, frame.data, frame.extended) for frame in frames] == [
        (0x021, b"\x01\x02", False),
        (0x12345, b"", True),
    ]
    assert all(before_ns - MS <= frame.stamp_ns <= time.monotonic_ns() for frame in frames)
    other.write([CanFrame(0x021, b"\x03")])
    assert [frame.data for frame in read(one, 1)] == [b"\x03"]


def test_packets_that_are_no_frames_are_counted_and_later_frames_come(
    multicast: tuple[CanPort, CanPort],
) -> None:
    one, other = multicast
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        stranger.sendto(b"hello", ("239.74.163.2", 20_000 + os.getpid() % 20_000))
    one.write([CanFrame(0x021, b"\x01")])
    assert [frame.data for frame in read(other, 1)] == [b"\x01"]
    assert other.counts == {"malformed frames": 1}


class Kernel:
    """What netlink would say of can0, and the socket of python-can on it."""

    def __init__(self, mocker: MockerFixture) -> None:
        self.link: CanLink | None = CanLink(3, True, "can", 250_000, 100, BusState.ERROR_ACTIVE)
        self.reachable = True
        self.bus = mocker.Mock(**{"recv.return_value": None, "fileno.side_effect": NotImplementedError})
        mocker.patch("can.Bus", return_value=self.bus)

    def look(self, name: str) -> CanLink | None:
        if not self.reachable:
            raise TimeoutError("timed out")
        return self.link if name == "can0" else None

    def bring(self, *messages: can.Message) -> None:
        self.bus.recv.side_effect = [*messages, *[None] * 100]


@fixture
def kernel(mocker: MockerFixture) -> Kernel:
    return Kernel(mocker)


@fixture
def can0(kernel: Kernel) -> Iterator[CanPort]:
    with closing(CanPort("can0", look=kernel.look)) as port:
        port.open()
        yield port


def health(port: CanPort, later_ns: int = 0) -> Health:
    return port.health(time.monotonic_ns() + later_ns)


def error_frame(classes: int, *data: int) -> can.Message:
    return can.Message(
        arbitration_id=classes, is_error_frame=True, data=bytes([*data, *bytes(8 - len(data))])
    )


def test_a_bus_off_is_told_and_frames_are_not_sent(kernel: Kernel, can0: CanPort) -> None:
    kernel.bring(error_frame(0x040))
    can0.read(0.0)
    can0.write([CanFrame(1, b"")])
    assert health(can0).state is State.BUS_OFF
    assert "can0: bus-off, started again after 100 ms" in health(can0).message
    assert health(can0).counts == {"bus-offs": 1, "error frames": 1, "unsent frames": 1}
    kernel.bus.send.assert_not_called()


def test_after_the_restart_frames_go_out_again(kernel: Kernel, can0: CanPort) -> None:
    kernel.bring(error_frame(0x040), error_frame(0x100))
    can0.read(0.0)
    can0.write([CanFrame(1, b"")])
    assert health(can0).state is State.WELL
    kernel.bus.send.assert_called_once()


def test_error_passive_is_told(kernel: Kernel, can0: CanPort) -> None:
    kernel.bring(error_frame(0x004, 0, 0x10))
    can0.read(0.0)
    assert health(can0).state is State.ERROR_PASSIVE


@mark.parametrize(
    "refusal", [can.CanOperationError("no", ENOBUFS), can.CanOperationError("Transmit buffer full")]
)
def test_a_full_queue_is_congestion_and_no_lost_port(
    kernel: Kernel, can0: CanPort, refusal: can.CanOperationError
) -> None:
    kernel.bus.send.side_effect = [None, refusal]
    can0.write([CanFrame(1, b""), CanFrame(2, b""), CanFrame(3, b"")])
    can0.write([CanFrame(4, b"")])
    assert health(can0).state is State.CONGESTED
    assert can0.counts == {"unsent frames": 3}
    assert kernel.bus.send.call_count == 2


def test_an_interface_that_is_gone_while_sending_is_a_lost_port(kernel: Kernel, can0: CanPort) -> None:
    kernel.bus.send.side_effect = can.CanOperationError("Failed to transmit", ENXIO)
    with raises(PortError, match="can0: CAN port lost"):
        can0.write([CanFrame(1, b"")])


def test_a_port_whose_socket_has_gone_deaf_is_lost_when_the_link_is_looked_at(
    kernel: Kernel, can0: CanPort
) -> None:
    kernel.link = None
    give_up = time.monotonic() + 5.0
    with raises(PortError, match=r"can0: CAN port lost, was it unplugged\?"):
        while time.monotonic() < give_up:
            can0.read(0.0)


def test_a_kernel_that_cannot_be_asked_loses_no_port(kernel: Kernel, can0: CanPort) -> None:
    kernel.reachable = False
    give_up = time.monotonic() + 0.7
    while time.monotonic() < give_up:
        can0.read(0.0)
    assert health(can0).state is State.WELL


def test_an_interface_that_is_down_is_named_with_the_mend(kernel: Kernel) -> None:
    kernel.link = CanLink(3, False, "can")
    with raises(
        PortError, match=r"can0: this CAN interface is down \(sudo ip link set can0 up type can bitrate"
    ):
        CanPort("can0", look=kernel.look).open()


def test_a_quiet_bus_says_what_to_check(can0: CanPort) -> None:
    assert health(can0, later_ns=2_000 * MS).state is State.SILENT
    assert "120 ohm" in health(can0, later_ns=2_000 * MS).message
