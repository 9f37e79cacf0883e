import struct
from collections.abc import Iterable
from itertools import pairwise
from math import tau
from random import Random
from typing import Any

import pytest

from echogrid.drivers.bus import CanFrame
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.vesc import Vesc, VescOptions, status, status_4, status_5

MS = 1_000_000
SECOND = 1000 * MS
NODE = 23
STATUS, STATUS_4, STATUS_5, NOTICE = (packet << 8 | NODE for packet in (9, 16, 27, 57))
TURNS_PER_S = 0.5
START_NS, NOTICE_NS = 400 * MS, 900 * MS


def vesc(**options: Any) -> Vesc:
    def angle(now_ns: int) -> float:
        return 7.0 + TURNS_PER_S * tau * now_ns / SECOND

    return Vesc("wheel", angle, Random(1), VescOptions(**{"node": NODE, **options}))


def on_bus(node: Vesc) -> CanBus:
    bus = CanBus("can", 500_000, [node])
    bus.switch_on(0)
    return bus


def of(identifier: int, frames: Iterable[CanFrame]) -> list[CanFrame]:
    return [frame for frame in frames if frame.identifier == identifier]


def sixths(frame: CanFrame) -> int:
    (count,) = struct.unpack(">i", frame.data[:4])
    assert isinstance(count, int)
    return count


def test_the_messages_are_those_of_the_source() -> None:
    assert status(-5000, 10.0, -0.5) == bytes.fromhex("FFFFEC780064FE0C")
    assert status_4(45.5, 30.1, -2.5, 359.9) == bytes.fromhex("01C7012DFFE7464B")
    assert status_5(-123456, 48.1) == bytes.fromhex("FFFE1DC001E10000")


def test_the_tachometer_wraps_at_two_to_the_31() -> None:
    assert status_5((1 << 31) - 1, 0.0)[:4] == bytes.fromhex("7FFFFFFF")
    assert status_5(1 << 31, 0.0)[:4] == bytes.fromhex("80000000")


def test_each_set_of_messages_has_its_own_rate_and_drifts_by_the_time_of_sending() -> None:
    frames = on_bus(vesc()).take(2 * SECOND)
    stamps = [frame.stamp_ns for frame in of(STATUS_5, frames)]
    assert {later - sooner for sooner, later in pairwise(stamps[:10])} == {20_100_000}
    assert len(of(STATUS, frames)) == len(stamps)
    assert 7 <= len(of(STATUS_4, frames)) <= 8
    assert {frame.extended for frame in frames} == {True}


def test_all_six_status_messages_can_be_sent_the_last_as_58() -> None:
    frames = on_bus(vesc(messages=0b111111, slow_messages=0)).take(SECOND)
    packets = {frame.identifier >> 8 for frame in frames}
    assert packets == {9, 14, 15, 16, 27, 58, 57}
    assert {len(frame.data) for frame in frames} == {8}


def test_it_starts_at_0_and_counts_six_times_for_each_pole_pair_and_turn() -> None:
    frames = of(STATUS_5, on_bus(vesc(pole_pairs=15)).take(5 * SECOND))
    assert sixths(frames[0]) == 0
    assert sixths(frames[-1]) == pytest.approx(
        90 * TURNS_PER_S * (frames[-1].stamp_ns - START_NS) / SECOND, abs=1
    )


def test_the_speed_is_that_of_the_poles() -> None:
    (erpm, *_) = struct.unpack(">ihh", of(STATUS, on_bus(vesc(gear=-2.0)).take(SECOND))[-1].data)
    assert erpm == -2 * 7 * TURNS_PER_S * 60


def test_the_gear_turns_the_motor_the_other_way() -> None:
    frames = of(STATUS_5, on_bus(vesc(gear=-4.0)).take(3 * SECOND))
    assert sixths(frames[-1]) == pytest.approx(-4 * 42 * TURNS_PER_S * 2.6, abs=4)


def test_the_boot_notice_comes_half_a_second_after_the_first_messages() -> None:
    frames = on_bus(vesc()).take(2 * SECOND)
    (notice,) = of(NOTICE, frames)
    assert NOTICE_NS < notice.stamp_ns < NOTICE_NS + MS
    assert START_NS < frames[0].stamp_ns < START_NS + 21 * MS


def test_commands_are_not_obeyed() -> None:
    frames = [frame.data for frame in on_bus(vesc()).take(SECOND)]
    bus = on_bus(vesc())
    bus.send((CanFrame(0x117, bytes.fromhex("0000C738"), extended=True),), 0)
    assert [frame.data for frame in bus.take(SECOND)] == frames


@pytest.mark.parametrize("verb", ["off", "unplug"])
def test_without_power_it_is_silent_and_comes_back_at_0(verb: str) -> None:
    node = vesc()
    bus = on_bus(node)
    bus.take(5011 * MS)
    node.fault(verb, 5011 * MS, SECOND)
    frames = bus.take(8 * SECOND)
    assert frames[0].stamp_ns > 6011 * MS + START_NS
    assert sixths(of(STATUS_5, frames)[0]) == 0
    assert len(of(NOTICE, frames)) == 1


def test_garbage_is_random_payloads_under_the_same_identifiers() -> None:
    node = vesc()
    bus = on_bus(node)
    node.fault("garbage", 0)
    frames = bus.take(2 * SECOND)
    assert {frame.identifier for frame in frames} == {STATUS, STATUS_4, STATUS_5, NOTICE}
    assert len({frame.data for frame in frames}) == len(frames)


def test_delayed_is_late_by_200_ms() -> None:
    node = vesc()
    bus = on_bus(node)
    node.fault("delayed", 0)
    assert 600 * MS < bus.take(SECOND)[0].stamp_ns < 621 * MS


def test_overheated_is_told_by_the_fets() -> None:
    node = vesc()
    bus = on_bus(node)
    assert struct.unpack(">hh", of(STATUS_4, bus.take(SECOND))[0].data[:4]) == (352, 352)
    node.fault("overheated", SECOND)
    assert struct.unpack(">hh", of(STATUS_4, bus.take(2 * SECOND))[-1].data[:4]) == (965, 352)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"node": 255}, "node 255"),
        ({"pole_pairs": 0}, "pole_pairs 0"),
        ({"period_ns": 9}, "millisecond"),
    ],
)
def test_impossible_options_are_refused(options: dict[str, int], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        vesc(**options)
