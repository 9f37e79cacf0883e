import struct
from math import tau
from random import Random

import pytest

from echogrid.drivers.bus import CanFrame
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.cansimple_axis import State
from echogrid.emulation.devices.odrive06 import ODrive06Axis, ODrive06Options, heartbeat
from echogrid.emulation.devices.odrive06 import version as told_version

MS = 1_000_000
SECOND = 1000 * MS
VERSION, HEARTBEAT, ESTIMATES, COUNTS = 0x060, 0x061, 0x069, 0x06A
REBOOT, SET_POSITION = 0x076, 0x079
TURNS_PER_S = 0.5
QUIET_NS = 5051 * MS
"""No frame is on the wire then."""


def axis() -> ODrive06Axis:
    return ODrive06Axis(
        "wheel", lambda now_ns: 7.0 + TURNS_PER_S * tau * now_ns / SECOND, Random(1), ODrive06Options(node=3)
    )


def on_bus(node: ODrive06Axis) -> CanBus:
    bus = CanBus("can", 500_000, [node])
    bus.switch_on(0)
    return bus


def of(identifier: int, frames: tuple[CanFrame, ...]) -> list[bytes]:
    return [frame.data for frame in frames if frame.identifier == identifier]


def test_heartbeats_are_those_of_the_sheet() -> None:
    assert heartbeat(State.IDLE) == bytes.fromhex("0000000001000000")
    assert heartbeat(State.CLOSED_LOOP, trajectory_done=True) == bytes.fromhex("0000000008000100")
    assert heartbeat(State.IDLE, error=0x0400_0008, result=3) == bytes.fromhex("0800000401030000")


def test_a_version_is_that_of_the_sheet() -> None:
    assert told_version((0, 6, 10)) == bytes.fromhex("0204043A00060A00")


def test_it_starts_up_initializing_then_busy_then_idle() -> None:
    told = of(HEARTBEAT, on_bus(axis()).take(550 * MS))
    assert [(data[0], data[4], data[5]) for data in told] == [(1, 0, 0)] * 2 + [(0, 2, 1)] * 2 + [
        (0, 1, 0)
    ] * 2


@pytest.mark.parametrize("remote", [True, False])
def test_it_tells_its_version_on_request(remote: bool) -> None:
    bus = on_bus(axis())
    bus.take(QUIET_NS)
    bus.send((CanFrame(VERSION, b"", remote=remote),), QUIET_NS)
    assert of(VERSION, bus.take(QUIET_NS + 3 * MS)) == [bytes.fromhex("0204043A00060A00")]


def test_it_knows_no_counts() -> None:
    bus = on_bus(axis())
    bus.take(QUIET_NS)
    bus.send((CanFrame(COUNTS, b"", remote=True),), QUIET_NS)
    assert of(COUNTS, bus.take(QUIET_NS + 20 * MS)) == []


def test_a_lost_encoder_is_a_missing_estimate_and_reads_0() -> None:
    node = axis()
    bus = on_bus(node)
    bus.take(SECOND)
    node.fault("encoder_lost", SECOND)
    frames = bus.take(2 * SECOND)
    assert of(HEARTBEAT, frames)[-1] == bytes.fromhex("0800000001000000")
    assert of(ESTIMATES, frames)[-1] == bytes(8)


def test_a_failed_motor_is_told_and_leaves_the_encoder() -> None:
    node = axis()
    bus = on_bus(node)
    bus.take(SECOND)
    node.fault("motor_failed", SECOND)
    frames = bus.take(2 * SECOND)
    assert of(HEARTBEAT, frames)[-1] == bytes.fromhex("2000000001030000")
    assert struct.unpack("<f", of(ESTIMATES, frames)[-1][4:]) == pytest.approx((TURNS_PER_S,))


def test_its_position_can_be_set() -> None:
    bus = on_bus(axis())
    bus.take(QUIET_NS)
    bus.send((CanFrame(SET_POSITION, struct.pack("<f", -300.0)),), QUIET_NS)
    frames = bus.take(QUIET_NS + SECOND)
    assert struct.unpack("<f", of(ESTIMATES, frames)[-1][:4])[0] == pytest.approx(-299.5, abs=0.01)
    velocities = [struct.unpack("<f", data[4:])[0] for data in of(ESTIMATES, frames)]
    assert velocities == pytest.approx([TURNS_PER_S] * len(velocities), abs=1e-4)


@pytest.mark.parametrize(("argument", "rebooted"), [(b"", True), (b"\0", True), (b"\1", False)])
def test_it_reboots_when_it_is_told_to(argument: bytes, rebooted: bool) -> None:
    bus = on_bus(axis())
    bus.take(QUIET_NS)
    bus.send((CanFrame(REBOOT, argument),), QUIET_NS)
    states = {data[4] for data in of(HEARTBEAT, bus.take(QUIET_NS + SECOND))}
    assert (State.UNDEFINED in states) is rebooted


@pytest.mark.parametrize("version", ["0.6", "new", "0.6.1000"])
def test_an_impossible_version_is_refused(version: str) -> None:
    with pytest.raises(ValueError, match="version"):
        ODrive06Options(version=version)


def test_an_impossible_node_is_refused() -> None:
    with pytest.raises(ValueError, match="node 64"):
        ODrive06Options(node=64)
