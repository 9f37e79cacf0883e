import struct
from itertools import pairwise
from math import tau
from random import Random

import pytest

from echogrid.drivers.bus import CanFrame
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.cansimple_axis import State, estimates
from echogrid.emulation.devices.odrive import ODriveAxis, ODriveOptions, counts, heartbeat

MS = 1_000_000
SECOND = 1000 * MS
STARTED = 400 * MS
HEARTBEAT, ESTIMATES, COUNTS = 0x061, 0x069, 0x06A
TURNS_PER_S = 0.5
REBOOT_NS = 5051 * MS
"""No frame is on the wire then."""


def axis(gear: float = 1.0) -> ODriveAxis:
    def angle(now_ns: int) -> float:
        return 7.0 + TURNS_PER_S * tau * now_ns / SECOND

    return ODriveAxis("wheel", angle, Random(1), ODriveOptions(node=3, gear=gear))


def on_bus(*nodes: ODriveAxis) -> CanBus:
    bus = CanBus("can", 500_000, nodes)
    bus.switch_on(0)
    return bus


def of(identifier: int, frames: tuple[CanFrame, ...]) -> list[CanFrame]:
    return [frame for frame in frames if frame.identifier == identifier]


def test_heartbeats_are_those_of_the_sheet() -> None:
    assert heartbeat(State.IDLE) == bytes.fromhex("0000000001000000")
    assert heartbeat(State.CLOSED_LOOP) == bytes.fromhex("0000000008000000")
    assert heartbeat(State.CLOSED_LOOP, trajectory_done=True) == bytes.fromhex("0000000008000080")
    assert heartbeat(State.IDLE, encoder_failed=True)[6] == 1


def test_estimates_and_counts_are_those_of_the_sheet() -> None:
    assert estimates(1.5, -2.25) == bytes.fromhex("0000C03F000010C0")
    assert counts(-5, 8192) == bytes.fromhex("FBFFFFFFFB1F0000")


def test_counts_wrap_at_two_to_the_31() -> None:
    assert struct.unpack("<i", counts(1 << 31, 8192)[:4]) == (-(1 << 31),)


def test_a_heartbeat_comes_every_100_ms_and_estimates_every_10_ms() -> None:
    frames = on_bus(axis()).take(999 * MS)
    assert len(of(HEARTBEAT, frames)) == 10
    stamps = [frame.stamp_ns for frame in of(ESTIMATES, frames)]
    assert len(stamps) == 100
    assert {later - sooner for sooner, later in pairwise(stamps)} == {10 * MS}


def test_it_starts_up_through_undefined_and_startup_to_idle() -> None:
    states = [frame.data[4] for frame in of(HEARTBEAT, on_bus(axis()).take(550 * MS))]
    assert states == [0, 0, 2, 2, 1, 1]


def test_estimates_are_0_until_it_is_idle_and_then_count_from_power_up() -> None:
    frames = of(ESTIMATES, on_bus(axis()).take(SECOND))
    early = [frame for frame in frames if frame.stamp_ns < STARTED]
    assert {frame.data for frame in early} == {bytes(8)}
    last = frames[-1]
    position, velocity = struct.unpack("<ff", last.data)
    assert position == pytest.approx(TURNS_PER_S * (last.stamp_ns - 222_000) / SECOND, abs=1e-6)
    assert velocity == pytest.approx(TURNS_PER_S)


def test_the_gear_turns_the_encoder_the_other_way() -> None:
    frames = of(ESTIMATES, on_bus(axis(gear=-2.0)).take(SECOND))
    assert struct.unpack("<ff", frames[-1].data)[1] == pytest.approx(-2 * TURNS_PER_S)


@pytest.mark.parametrize("remote", [True, False])
@pytest.mark.parametrize("identifier", [ESTIMATES, COUNTS])
def test_a_request_is_answered_after_the_time_of_two_frames(identifier: int, remote: bool) -> None:
    bus = on_bus(axis())
    quiet_ns = bus.take(950 * MS)[-1].stamp_ns + 5 * MS
    bus.take(quiet_ns)
    bus.send((CanFrame(identifier, b"", remote=remote),), quiet_ns)
    (answer,) = bus.take(quiet_ns + 3 * MS)
    assert answer.identifier == identifier
    assert answer.stamp_ns == quiet_ns + (47 + 47 + 64) * 2000


def test_requests_to_another_node_are_not_answered() -> None:
    bus = on_bus(axis())
    quiet_ns = bus.take(950 * MS)[-1].stamp_ns + 5 * MS
    bus.send((CanFrame(0x089, b"", remote=True),), quiet_ns)
    assert bus.take(quiet_ns + 3 * MS) == ()


def test_a_reboot_restarts_the_position_at_0() -> None:
    bus = on_bus(axis())
    bus.take(REBOOT_NS)
    bus.send((CanFrame(0x076, b""),), REBOOT_NS)
    frames = bus.take(REBOOT_NS + SECOND)
    assert of(HEARTBEAT, frames)[0].data[4] == State.UNDEFINED
    assert struct.unpack("<f", of(ESTIMATES, frames)[-1].data[:4])[0] == pytest.approx(0.5, abs=0.01)


def test_of_two_frames_the_lower_identifier_goes_first() -> None:
    first = ODriveAxis("a", lambda now_ns: 0.0, Random(1), ODriveOptions(node=5))
    second = ODriveAxis("b", lambda now_ns: 0.0, Random(1), ODriveOptions(node=2))
    frames = on_bus(first, second).take(2 * MS)
    assert [frame.identifier for frame in frames[:2]] == [2 << 5 | 1, 5 << 5 | 1]
    assert frames[1].stamp_ns - frames[0].stamp_ns == 111 * 2000


def test_garbage_is_random_payloads_under_the_same_identifiers() -> None:
    node = axis()
    bus = on_bus(node)
    node.fault("garbage", 0)
    frames = bus.take(SECOND)
    assert {frame.identifier for frame in frames} == {HEARTBEAT, ESTIMATES}
    assert len({frame.data for frame in frames}) == len(frames)


def test_delayed_is_late_by_200_ms() -> None:
    node = axis()
    bus = on_bus(node)
    node.fault("delayed", 0)
    after_ns = [frame.stamp_ns for frame in bus.take(SECOND)][1]
    assert 200 * MS < after_ns < 210 * MS + 222_000


@pytest.mark.parametrize("verb", ["off", "unplug"])
def test_without_power_it_is_silent_and_comes_back_at_0(verb: str) -> None:
    node = axis()
    bus = on_bus(node)
    bus.take(REBOOT_NS)
    node.fault(verb, REBOOT_NS, SECOND)
    assert bus.take(REBOOT_NS + SECOND - 1) == ()
    frames = bus.take(REBOOT_NS + 2 * SECOND)
    assert of(HEARTBEAT, frames)[0].data[4] == State.UNDEFINED
    assert struct.unpack("<f", of(ESTIMATES, frames)[-1].data[:4])[0] == pytest.approx(0.5, abs=0.01)


def test_a_lost_encoder_is_flagged_and_reads_0() -> None:
    node = axis()
    bus = on_bus(node)
    bus.take(SECOND)
    node.fault("encoder_lost", SECOND)
    frames = bus.take(2 * SECOND)
    assert of(HEARTBEAT, frames)[-1].data == bytes.fromhex("0000000001000100")
    assert of(ESTIMATES, frames)[-1].data == bytes(8)


def test_an_unplugged_adapter_does_not_stop_the_axis() -> None:
    bus = on_bus(axis())
    bus.take(5 * SECOND)
    bus.fault("unplug", 5 * SECOND, SECOND)
    frames = bus.take(7 * SECOND)
    assert frames[0].stamp_ns >= 6 * SECOND
    assert struct.unpack("<f", of(ESTIMATES, frames)[-1].data[:4])[0] == pytest.approx(3.5, abs=0.01)


def test_a_failed_motor_is_flagged_and_leaves_the_encoder() -> None:
    node = axis()
    bus = on_bus(node)
    bus.take(SECOND)
    node.fault("motor_failed", SECOND)
    frames = bus.take(2 * SECOND)
    assert of(HEARTBEAT, frames)[-1].data == bytes.fromhex("0000000001010000")
    assert struct.unpack("<f", of(ESTIMATES, frames)[-1].data[4:]) == pytest.approx((TURNS_PER_S,))


def test_counts_come_by_themselves_when_they_are_configured() -> None:
    options = ODriveOptions(node=3, counts_per_turn=4096, counts_ns=20 * MS)
    node = ODriveAxis("wheel", lambda now_ns: tau * now_ns / SECOND, Random(1), options)
    frames = of(COUNTS, on_bus(node).take(2 * SECOND))
    assert len(frames) == pytest.approx(100, abs=1)
    (shadow, within) = struct.unpack("<ii", frames[-1].data)
    assert shadow == pytest.approx(4096 * frames[-1].stamp_ns / SECOND, abs=5)
    assert within == shadow % 4096


def test_its_count_can_be_set() -> None:
    bus = on_bus(axis())
    bus.take(REBOOT_NS)
    bus.send((CanFrame(0x079, struct.pack("<i", -8192)),), REBOOT_NS)
    last = of(ESTIMATES, bus.take(REBOOT_NS + SECOND))[-1]
    assert struct.unpack("<f", last.data[:4])[0] == pytest.approx(-0.5, abs=0.01)


def test_it_gives_no_answer_to_a_request_for_its_version() -> None:
    bus = on_bus(axis())
    bus.take(REBOOT_NS)
    bus.send((CanFrame(0x060, b"", remote=True),), REBOOT_NS)
    assert of(0x060, bus.take(REBOOT_NS + SECOND)) == []
