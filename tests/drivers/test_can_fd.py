"""CAN-FD through the CAN port, and what is said of links that are set up without it."""

import os
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from typing import Any

import can
import pytest
from pytest import fixture, mark, raises
from pytest_mock import MockerFixture

from echogrid.drivers.bus import FD_LENGTHS, CanFrame
from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.can import CanPort
from echogrid.drivers.transports.can_link import BusState, CanLink
from echogrid.drivers.transports.can_supervisor import CanSupervisor, classic, down
from echogrid.drivers.transports.ports import make_port

FD_LINE = (
    "sudo ip link set can0 up type can bitrate 1000000 sample-point 0.666 dbitrate 5000000 "
    "dsample-point 0.666 fd on restart-ms 100"
)
LINK = CanLink(3, True, "can", 1_000_000, 100, BusState.ERROR_ACTIVE, mtu=72, data_bitrate=5_000_000)


def message(length: int, **more: Any) -> can.Message:
    return can.Message(
        arbitration_id=0x100, data=bytes(range(length)), is_extended_id=False, is_fd=True, **more
    )


@fixture
def peer() -> Iterator[can.BusABC]:
    protocol = can.CanProtocol.CAN_FD
    with can.Bus(channel="fd", interface="virtual", ignore_config=True, protocol=protocol) as peer:
        yield peer


@fixture
def port(peer: can.BusABC) -> Iterator[CanPort]:
    made = make_port("can", "fd", {"interface": "virtual", "bitrate": 1_000_000, "fd": True})
    assert isinstance(made, CanPort)
    with closing(made) as port:
        port.open()
        yield port


def read(port: CanPort, count: int) -> list[CanFrame]:
    """That many frames, or fewer if they do not come."""
    frames: list[CanFrame] = []
    give_up = time.monotonic() + 5.0
    while len(frames) < count and time.monotonic() < give_up:
        frames += port.read(1.0)
    return frames


def test_frames_of_every_length_come_in(peer: can.BusABC, port: CanPort) -> None:
    for length in FD_LENGTHS:
        peer.send(message(length))
    frames = read(port, len(FD_LENGTHS))
    assert [frame.data for frame in frames] == [bytes(range(length)) for length in FD_LENGTHS]
    assert all(frame.fd for frame in frames)
    assert port.counts == {}


def test_classic_frames_come_in_beside_them_and_are_told_apart(peer: can.BusABC, port: CanPort) -> None:
    peer.send(message(8))
    peer.send(can.Message(arbitration_id=0x100, data=bytes(range(8)), is_extended_id=False))
    faster, slower = read(port, 2)
    assert (faster.fd, slower.fd) == (True, False)
    assert replace(faster, fd=False, stamp_ns=0) == replace(slower, stamp_ns=0)


@mark.parametrize("length", [9, 11, 13, 33, 63, 65])
def test_a_length_that_there_is_not_is_counted(peer: can.BusABC, port: CanPort, length: int) -> None:
    peer.send(message(length))
    peer.send(message(1))
    assert [frame.data for frame in read(port, 1)] == [b"\0"]
    assert port.counts == {"malformed frames": 1}


def test_a_remote_frame_of_can_fd_is_none(peer: can.BusABC, port: CanPort) -> None:
    peer.send(message(0, is_remote_frame=True))
    peer.send(message(1))
    assert len(read(port, 1)) == 1
    assert port.counts == {"malformed frames": 1}


def test_a_classic_frame_has_eight_bytes_at_most(peer: can.BusABC, port: CanPort) -> None:
    peer.send(can.Message(arbitration_id=0x100, data=bytes(12), is_extended_id=False))
    peer.send(message(1))
    assert len(read(port, 1)) == 1
    assert port.counts == {"malformed frames": 1}


def test_frames_go_out_with_the_faster_bit_rate_if_they_are_of_can_fd(
    peer: can.BusABC, port: CanPort
) -> None:
    port.write([CanFrame(0x8001, bytes(12), extended=True, fd=True), CanFrame(0x21, bytes(8))])
    faster, slower = peer.recv(1.0), peer.recv(1.0)
    assert faster and slower
    assert (faster.is_fd, faster.bitrate_switch, faster.dlc) == (True, True, 12)
    assert (slower.is_fd, slower.bitrate_switch) == (False, False)


def test_a_classic_port_takes_no_frame_of_can_fd_for_its_own(peer: can.BusABC) -> None:
    with closing(CanPort("fd", interface="virtual")) as port:
        port.open()
        peer.send(message(8))
        peer.send(can.Message(arbitration_id=0x21, is_extended_id=False))
        assert [frame.identifier for frame in read(port, 1)] == [0x21]
        assert port.counts == {"malformed frames": 1}


def test_slcan_is_refused_with_the_mend() -> None:
    with raises(ValueError, match=r'slcan has no CAN-FD: use an adapter .*interface "socketcan"'):
        make_port("can", "/dev/ttyACM0", {"interface": "slcan", "bitrate": 1_000_000, "fd": True})


def test_an_interface_whose_driver_has_no_can_fd_is_refused(mocker: MockerFixture) -> None:
    bus = mocker.Mock(protocol=can.CanProtocol.CAN_20)
    mocker.patch("can.Bus", return_value=bus)
    with raises(PortError, match="0: cannot open this CAN port: python-can's gs_usb has no CAN-FD"):
        CanPort("0", interface="gs_usb", bitrate=1_000_000, fd=True).open()
    bus.shutdown.assert_called_once()


def test_python_can_is_told_what_it_wants(mocker: MockerFixture) -> None:
    bus = mocker.Mock(
        protocol=can.CanProtocol.CAN_FD, **{"recv.return_value": None, "fileno.return_value": 0}
    )
    made = mocker.patch("can.Bus", return_value=bus)
    CanPort("can0", interface="socketcan", bitrate=1_000_000, fd=True, look=lambda _: LINK).open()
    assert made.call_args.kwargs == {
        "channel": "can0",
        "ignore_config": True,
        "interface": "socketcan",
        "bitrate": 1_000_000,
        "fd": True,
    }
    CanPort("PCAN_USBBUS1", interface="pcan", bitrate=1_000_000, fd=True).open()
    timing = made.call_args.kwargs["timing"]
    assert (timing.nom_bitrate, timing.data_bitrate) == (1_000_000, 5_000_000)
    assert timing.nom_sample_point == pytest.approx(66.6, abs=1.5)
    assert timing.data_sample_point == pytest.approx(66.6, abs=3.0)


def test_a_link_without_can_fd_is_told_with_the_line_that_mends_it() -> None:
    port = CanPort("can0", bitrate=1_000_000, fd=True, look=lambda _: replace(LINK, mtu=16))
    with raises(PortError) as raised:
        port.open()
    mend = f"(sudo ip link set can0 down && {FD_LINE})"
    assert str(raised.value) == f"can0: this CAN interface is set up without CAN-FD {mend}"


def test_a_virtual_link_without_can_fd_is_told_so_too() -> None:
    told = classic("vcan0", CanLink(3, True, "vcan", mtu=16), 1_000_000)
    assert told.endswith("(sudo ip link set vcan0 down && sudo ip link set vcan0 mtu 72 up)")


def test_a_link_with_can_fd_serves_classic_devices() -> None:
    bus = CanSupervisor("can0", 1_000_000, Counter())
    bus.opened(0, replace(LINK, data_bitrate=2_000_000))
    assert bus.condition(0).message == ""


def test_another_bit_rate_of_the_data_is_told_with_the_line_that_mends_it() -> None:
    bus = CanSupervisor("can0", 1_000_000, Counter(), fd=True)
    bus.opened(0, replace(LINK, data_bitrate=2_000_000))
    told = bus.condition(0).message
    assert "can0 has 2000000 bit/s for the data of CAN-FD, not 5000000" in told
    assert told.endswith(f"sudo ip link set can0 down && {FD_LINE}")
    bus.opened(0, LINK)
    assert bus.condition(0).message == ""


def test_a_link_that_is_down_is_to_be_set_up_with_can_fd() -> None:
    told = down("can0", replace(LINK, up=False, bitrate=None), 1_000_000, fd=True)
    assert told == f"can0: this CAN interface is down ({FD_LINE})"


def test_frames_cross_by_udp_multicast_and_nobody_hears_itself() -> None:
    pytest.importorskip("msgpack", reason="udp_multicast needs msgpack")
    more = {"port": 20_000 + os.getpid() % 20_000, "hop_limit": 0}
    ports = [
        CanPort("239.74.163.3", interface="udp_multicast", bitrate=1_000_000, fd=True, more=more)
        for _ in range(2)
    ]
    with closing(ports[0]), closing(ports[1]):
        try:
            for port in ports:
                port.open()
            ports[0].write([CanFrame(0x8001, bytes(12), extended=True, fd=True)])
        except PortError as error:
            pytest.skip(f"no multicast on this machine: {error}")
        frames = read(ports[1], 1)
        if not frames:
            pytest.skip("multicast does not come back to this machine")
        assert [(frame.identifier, len(frame.data), frame.fd) for frame in frames] == [(0x8001, 12, True)]
        assert ports[0].read(0.0) == []
