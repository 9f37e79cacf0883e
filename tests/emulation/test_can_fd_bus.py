"""CAN-FD on the emulated bus and its wires."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from pytest import approx, raises

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.emulation.buses.can_bus import CanBus, frame_time_ns
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.wires.vcan import decode, encode, require_fd


class Ear(CanNode):
    """Notes what it hears, and when."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.heard: list[tuple[int, CanFrame]] = []

    def receive(self, frame: CanFrame, now_ns: int) -> None:
        self.heard.append((now_ns, frame))

    def _step(self, now_ns: int) -> None:
        pass

    def _next_ns(self) -> int:
        return NEVER_NS

    def _power_up(self, now_ns: int) -> None:
        pass

    def _power_down(self) -> None:
        pass


class FastEar(Ear):
    """One that knows CAN-FD."""

    fd = True


def on_bus(nodes: Sequence[CanNode], bit_rate: int = 1_000_000) -> CanBus:
    bus = CanBus("can", bit_rate, nodes)
    bus.switch_on(0)
    return bus


def test_the_data_take_their_time_at_their_own_bit_rate() -> None:
    short, long = (CanFrame(1, bytes(length), fd=True) for length in (16, 20))
    assert frame_time_ns(short, 1_000_000, 5_000_000) == 29_000 + (33 + 128) * 200
    assert frame_time_ns(long, 1_000_000, 5_000_000) == 29_000 + (38 + 160) * 200
    extended = CanFrame(1, bytes(64), extended=True, fd=True)
    assert frame_time_ns(extended, 1_000_000, 5_000_000) == 48_000 + (38 + 512) * 200


def test_a_classic_frame_takes_as_long_as_ever() -> None:
    assert frame_time_ns(CanFrame(1, bytes(8)), 500_000, 5_000_000) == 222_000
    assert frame_time_ns(CanFrame(1, bytes(8), extended=True), 500_000, 5_000_000) == 262_000


def test_nodes_without_can_fd_hear_classic_frames_only() -> None:
    slow, fast = Ear("slow"), FastEar("fast")
    bus = on_bus([slow, fast])
    bus.send((CanFrame(1, bytes(8), fd=True), CanFrame(2, bytes(8))), 0)
    bus.take(1_000_000)
    assert [frame.identifier for _, frame in slow.heard] == [2]
    assert [(frame.identifier, frame.fd) for _, frame in fast.heard] == [(1, True), (2, False)]
    assert fast.heard[0][0] == approx(29_000 + 97 * 200)


def test_a_bus_knows_whether_anybody_speaks_can_fd() -> None:
    assert not on_bus([Ear("slow")]).fd
    assert on_bus([Ear("slow"), FastEar("fast")]).fd


def test_a_frame_and_the_kernels_own_are_one_to_one() -> None:
    # struct canfd_frame of linux/can.h: identifier, length, flags (CANFD_BRS), two reserved, 64 of data
    frame = CanFrame(0x8001, bytes(range(12)), extended=True, fd=True)
    packed = bytes.fromhex("01800080 0C 01 0000") + bytes(range(12)) + bytes(52)
    assert encode(frame) == packed
    assert decode(packed) == frame
    assert decode(encode(CanFrame(0x100, bytes(8), fd=True))) == CanFrame(0x100, bytes(8), fd=True)


def test_classic_frames_are_as_they_were() -> None:
    frame = CanFrame(0x021, b"\x01\x02")
    assert len(encode(frame)) == 16
    assert decode(encode(frame)) == frame


@pytest.mark.parametrize(("mtu", "taken"), [(16, False), (72, True), (2060, True)])
def test_an_interface_without_can_fd_is_told_with_the_mend(tmp_path: Path, mtu: int, taken: bool) -> None:
    (tmp_path / "vcan0").mkdir()
    (tmp_path / "vcan0" / "mtu").write_text(f"{mtu}\n")
    if taken:
        require_fd("vcan0", tmp_path)
    else:
        with raises(OSError, match="sudo ip link set vcan0 down && sudo ip link set vcan0 mtu 72 up"):
            require_fd("vcan0", tmp_path)
