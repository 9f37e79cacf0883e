"""What is published of obstacles on the kernel's own bus, as another program's socket gets it."""

import socket
import struct
import time
from collections.abc import Iterator
from contextlib import closing

from pytest import fixture, mark

from echogrid.drivers.clock import MonotonicClock
from echogrid.drivers.device import Line
from echogrid.drivers.transports.can import CanPort
from echogrid.mapping.unknown import Unknown
from echogrid.mapping.virtual_sensor import ObstacleView, Sector, SectorState
from echogrid.runtime.outputs.beacon import Beacon
from echogrid.runtime.outputs.pace import Pace
from echogrid.runtime.pump import Pump
from hil_tests.kernel import add_vcan

BUS = "vcan3"
FRAME = struct.Struct("=IB3x8s")
IDENTIFIER = 0x300
SILENCE_S = 0.3

pytestmark = mark.usefixtures("guest")


@fixture
def listener(guest: None) -> Iterator[socket.socket]:
    """Who is to stop a motor: a bare socket of the kernel's, which waits for so long at the most."""
    add_vcan(BUS)
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as bare:
        bare.bind((BUS,))
        bare.settimeout(SILENCE_S)
        yield bare


def heard(listener: socket.socket) -> list[tuple[int, str]]:
    """Identifiers and bytes, until it is silent."""
    frames: list[tuple[int, str]] = []
    while True:
        try:
            identifier, length, data = FRAME.unpack(listener.recv(FRAME.size))
        except TimeoutError:
            return frames
        frames.append((identifier, data[:length].hex()))


def view_at(now_ns: int) -> ObstacleView:
    return ObstacleView(now_ns, (Sector(0.0, SectorState.BLOCKED, 0.5),), None, Unknown.BLOCKED)


def test_each_view_is_two_frames_and_the_heartbeat_ends_with_the_views(listener: socket.socket) -> None:
    beacon = Beacon("can:bench:0x300", IDENTIFIER, Pace(20.0))
    with closing(CanPort(BUS)) as port:
        pump = Pump(Line("bench", [beacon]), port, MonotonicClock(), lambda _: None)
        for _ in range(3):
            beacon.put(view_at(time.monotonic_ns()))
            until = time.monotonic() + 0.1
            while time.monotonic() < until:
                pump.turn()
    frames = heard(listener)
    assert [identifier for identifier, _ in frames] == [IDENTIFIER, IDENTIFIER + 1] * 3
    assert [data[:4] for _, data in frames] == ["0100", "0100", "0101", "0101", "0102", "0102"]
    assert beacon.sent == 3
    assert heard(listener) == []
