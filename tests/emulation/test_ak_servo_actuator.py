import struct
from itertools import pairwise
from math import tau
from random import Random
from typing import Any

import pytest

from echogrid.drivers.bus import CanFrame
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.ak_servo import AkServo, AkServoOptions, upload

MS = 1_000_000
SECOND = 1000 * MS
NODE = 0x68
TURNS_PER_S = 2.0
START_NS = 400 * MS


def servo(**options: Any) -> AkServo:
    def angle(now_ns: int) -> float:
        return 7.0 + TURNS_PER_S * tau * now_ns / SECOND

    return AkServo("wheel", angle, Random(1), AkServoOptions(**{"node": NODE, **options}))


def on_bus(node: AkServo) -> CanBus:
    bus = CanBus("can", 1_000_000, [node])
    bus.switch_on(0)
    return bus


def positions(frames: tuple[CanFrame, ...]) -> list[int]:
    return [struct.unpack(">h", frame.data[:2])[0] for frame in frames]


def test_the_upload_is_that_of_the_manual() -> None:
    assert upload(-1234, 1500, -3.21, 35, 0) == bytes.fromhex("FB2E0096FEBF2300")
    assert upload(0, 0, 0.0, -20, 5)[6:] == b"\xec\x05"


def test_an_upload_comes_every_10_ms_from_its_own_identifier() -> None:
    frames = on_bus(servo()).take(2 * SECOND)
    assert {frame.identifier for frame in frames} == {0x2968}
    assert {frame.extended for frame in frames} == {True}
    assert {later.stamp_ns - sooner.stamp_ns for sooner, later in pairwise(frames)} == {10 * MS}
    assert START_NS < frames[0].stamp_ns < START_NS + 11 * MS


def test_the_position_counts_tenths_of_a_degree_from_power_up() -> None:
    frames = on_bus(servo(gear=-1.0)).take(3 * SECOND)
    expected = -3600 * TURNS_PER_S * (frames[-1].stamp_ns - 131_000 - START_NS) / SECOND
    assert positions(frames)[-1] == pytest.approx(expected, abs=1.5)


@pytest.mark.parametrize(("gear", "edge"), [(1.0, 32_767), (-1.0, -32_768)])
def test_the_position_wraps_as_sixteen_bits_do(gear: float, edge: int) -> None:
    told = positions(on_bus(servo(gear=gear)).take(6 * SECOND))
    ((last, first),) = [(old, new) for old, new in pairwise(told) if abs(new - old) > 1000]
    assert last == pytest.approx(edge, abs=72)
    assert abs(last - first) == pytest.approx(65_536 - 72, abs=1)


def test_the_position_may_stop_at_its_end_while_the_speed_goes_on() -> None:
    frames = on_bus(servo(ends="stop")).take(6 * SECOND)
    assert positions(frames)[-1] == positions(frames)[-2] == 32_000
    (tens,) = struct.unpack(">h", frames[-1].data[2:4])
    assert tens == TURNS_PER_S * 60 * 21 * 9 / 10


def test_faults_of_heat_and_encoder_are_told_by_their_errors() -> None:
    node = servo()
    bus = on_bus(node)
    node.fault("overheated", 0, SECOND)
    assert bus.take(SECOND - MS)[-1].data[6:] == bytes([96, 1])
    node.fault("encoder_lost", SECOND, SECOND)
    assert bus.take(2 * SECOND - MS)[-1].data == bytes([0, 0, 0, 0, 0, 0, 35, 5])
    assert bus.take(3 * SECOND)[-1].data[6:] == bytes([35, 0])


@pytest.mark.parametrize("verb", ["off", "unplug"])
def test_without_power_it_is_silent_and_comes_back_at_0(verb: str) -> None:
    node = servo()
    bus = on_bus(node)
    bus.take(2 * SECOND)
    node.fault(verb, 2 * SECOND, SECOND)
    frames = bus.take(4 * SECOND)
    first = next(frame for frame in frames if frame.stamp_ns > 2 * SECOND + 10 * MS)
    assert first.stamp_ns > 3 * SECOND + START_NS
    assert 0 <= positions((first,))[0] <= 72


def test_garbage_is_random_payloads_under_the_same_identifier() -> None:
    node = servo()
    bus = on_bus(node)
    node.fault("garbage", 0)
    frames = bus.take(SECOND)
    assert {frame.identifier for frame in frames} == {0x2968}
    assert len({frame.data for frame in frames}) == len(frames)


def test_delayed_is_late_by_200_ms() -> None:
    node = servo()
    bus = on_bus(node)
    node.fault("delayed", 0)
    assert 600 * MS < bus.take(SECOND)[0].stamp_ns < 611 * MS


def test_commands_are_not_obeyed() -> None:
    frames = [frame.data for frame in on_bus(servo()).take(SECOND)]
    bus = on_bus(servo())
    bus.send((CanFrame(0x568, b"\x01", extended=True),), 0)
    assert [frame.data for frame in bus.take(SECOND)] == frames


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"node": 256}, "node 256"),
        ({"packet": 1 << 21}, "packet 0x200000"),
        ({"period_ns": 1}, "1 to 500 times"),
        ({"ends": "bounce"}, "'bounce'"),
    ],
)
def test_impossible_options_are_refused(options: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        servo(**options)
