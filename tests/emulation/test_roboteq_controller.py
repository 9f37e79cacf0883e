import struct
from collections.abc import Iterable
from itertools import pairwise
from math import tau
from random import Random
from typing import Any

import pytest

from echogrid.drivers.bus import CanFrame
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.roboteq import minican, roboteq
from echogrid.emulation.devices.roboteq_counter import RoboteqOptions

MS = 1_000_000
SECOND = 1000 * MS
NODE = 5
START_NS = 400 * MS
TURNS_PER_S = 0.5
PER_TURN = 2000


class Bench:
    """A controller whose wheel turns evenly, or else as is said, and what comes from it."""

    def __init__(self, turns_per_s: float = TURNS_PER_S, **options: Any) -> None:
        def angle(now_ns: int) -> float:
            return 7.0 + turns_per_s * tau * now_ns / SECOND

        chosen = RoboteqOptions(**{"node": NODE, **options})
        self.node: CanNode = roboteq("wheel", angle, Random(1), chosen)
        self.bus = CanBus("can", 500_000, [self.node])
        self.bus.switch_on(0)
        self.now_ns = 0

    def run(self, milliseconds: int) -> list[CanFrame]:
        """What comes meanwhile."""
        self.now_ns += milliseconds * MS
        return list(self.bus.take(self.now_ns))

    def ask(self, index: int, sub: int) -> bytes:
        """The reply to a request for an object, within 5 ms; empty if there is none."""
        request = bytes((0x40, index & 0xFF, index >> 8, sub, 0, 0, 0, 0))
        self.bus.send([CanFrame(0x600 + NODE, request)], self.now_ns)
        replies = of(0x580 + NODE, self.run(5))
        return replies[0].data if replies else b""

    def value(self, index: int, sub: int) -> int:
        """What an object of 4 bytes holds."""
        reply = self.ask(index, sub)
        assert reply[0] == 0x43
        return int.from_bytes(reply[4:], "little", signed=True)


def of(identifier: int, frames: Iterable[CanFrame]) -> list[CanFrame]:
    return [frame for frame in frames if frame.identifier == identifier]


def pair(frame: CanFrame) -> tuple[int, int]:
    first, second = struct.unpack("<ii", frame.data)
    return first, second


def test_it_boots_and_is_operational_by_itself() -> None:
    beats = of(0x700 + NODE, Bench().run(1000))
    assert START_NS < beats[0].stamp_ns < START_NS + MS
    assert [frame.data for frame in beats] == [b"\x00"] + [b"\x05"] * 5
    assert {later.stamp_ns - sooner.stamp_ns for sooner, later in pairwise(beats)} == {100 * MS}


def test_its_master_may_have_to_start_it() -> None:
    bench = Bench(start="master", source="variable")
    frames = bench.run(1000)
    assert {frame.identifier for frame in frames} == {0x700 + NODE}
    assert frames[-1].data == b"\x7f"
    bench.bus.send([CanFrame(0, bytes((1, NODE)))], bench.now_ns)
    assert of(0x180 + NODE, bench.run(100))


def test_the_absolute_counter_begins_at_0_and_is_little_endian() -> None:
    bench = Bench()
    bench.run(2400)
    reply = bench.ask(0x2104, 1)
    assert reply[:4] == bytes.fromhex("43 04 21 01")
    assert int.from_bytes(reply[4:], "little") == pytest.approx(2 * TURNS_PER_S * PER_TURN, abs=2)


def test_the_gear_turns_the_encoder_the_other_way() -> None:
    bench = Bench(gear=-4.0)
    bench.run(2400)
    assert bench.value(0x2104, 1) == pytest.approx(-8 * TURNS_PER_S * PER_TURN, abs=8)


def test_the_counter_wraps_at_two_to_the_31() -> None:
    bench = Bench(origin=(1 << 31) - 100)
    bench.run(2400)
    assert bench.value(0x2104, 1) == pytest.approx(-(1 << 31) - 100 + 2000, abs=2)


def test_the_relative_counter_is_gone_once_it_was_asked_for_heard_or_not() -> None:
    bench = Bench()
    bench.run(2400)
    assert bench.value(0x2108, 1) == pytest.approx(2000, abs=2)
    assert bench.value(0x2108, 1) == pytest.approx(5, abs=1)
    bench.run(1000)
    bench.bus.send([CanFrame(0x605, bytes.fromhex("40 08 21 01 00000000"))], bench.now_ns)
    bench.run(5)
    assert bench.value(0x2108, 1) == pytest.approx(5, abs=1)


def test_its_speeds_are_those_of_the_encoder() -> None:
    bench = Bench(turns_per_s=25.0, gear=-2.0)
    bench.run(1000)
    assert bench.value(0x2103, 1) == -3000
    assert bench.ask(0x2107, 1)[:6] == bytes.fromhex("4B 07 21 01 18 FC")


def test_a_brushed_controller_has_no_hall_sensors() -> None:
    bench = Bench()
    bench.run(1000)
    assert bench.ask(0x2105, 1) == bytes.fromhex("80 05 21 01 00 00 02 06")


def test_a_brushless_one_counts_by_them() -> None:
    bench = Bench(encoder="brushless", counts_per_turn=60, channel=2)
    bench.run(2400)
    assert bench.value(0x2105, 2) == pytest.approx(60, abs=1)
    assert bench.value(0x2104, 2) == 0
    assert bench.value(0x2109, 2) == pytest.approx(60, abs=1)
    assert bench.ask(0x210A, 2)[:6] == bytes.fromhex("4B 0A 21 02 1E 00")


def test_two_of_one_node_answer_for_their_own_channel_each() -> None:
    bench = Bench(channel=2)
    bench.run(1000)
    assert bench.ask(0x2104, 1) == b""
    assert bench.ask(0x2104, 2)[0] == 0x43
    assert bench.ask(0x2104, 4) == bytes.fromhex("80 04 21 04 11 00 09 06")


def test_without_a_script_no_variable_is_written_or_sent() -> None:
    bench = Bench()
    assert {frame.identifier for frame in bench.run(2000)} == {0x700 + NODE}
    assert [bench.value(0x2106, number) for number in range(1, 9)] == [0] * 8


@pytest.mark.parametrize("variable", range(1, 9))
def test_the_script_copies_the_counter_into_its_variable(variable: int) -> None:
    bench = Bench(source="variable", variable=variable)
    frames = [frame for frame in bench.run(2400) if frame.identifier < 0x700]
    assert {frame.identifier for frame in frames} == {0x80 + 0x100 * ((variable + 1) // 2) + NODE}
    assert {later.stamp_ns - sooner.stamp_ns for sooner, later in pairwise(frames)} == {20 * MS}
    values = pair(frames[-1])
    assert values[(variable - 1) % 2] == pytest.approx(1980, abs=22)
    assert values[variable % 2] == 0
    assert bench.value(0x2106, variable) == pytest.approx(2000, abs=4)


def test_a_halted_script_leaves_its_variable_as_it_is() -> None:
    bench = Bench(source="variable")
    bench.run(1000)
    assert bench.ask(0x2111, 0)[4:6] == b"\x81\0"
    bench.node.fault("script_halted", bench.now_ns, SECOND)
    assert len({pair(frame) for frame in of(0x185, bench.run(900))}) == 1
    assert bench.ask(0x2111, 0)[4:6] == b"\x01\0"
    bench.run(200)
    assert len({pair(frame) for frame in of(0x185, bench.run(900))}) > 40


def test_the_tpdos_of_minican_are_those_of_the_manual() -> None:
    values = [0x12345678, -1, 3, 4]
    assert minican(1, values) == bytes.fromhex("78563412 FFFFFFFF")
    assert minican(2, values) == bytes.fromhex("03000000 04000000")
    assert (minican(3, values), minican(4, values)) == (bytes(8), bytes(4))


def test_minican_sends_four_tpdos_in_turn_and_a_heartbeat_and_hears_nothing() -> None:
    bench = Bench(mode="minican", source="variable", variable=3)
    frames = bench.run(2400)
    pdos = [frame for frame in frames if frame.identifier < 0x700]
    assert [frame.identifier - NODE for frame in pdos[:5]] == [0x180, 0x280, 0x380, 0x480, 0x180]
    assert {later.stamp_ns - sooner.stamp_ns for sooner, later in pairwise(of(0x285, pdos))} == {80 * MS}
    assert pair(of(0x285, pdos)[-1])[0] == pytest.approx(1960, abs=40)
    assert {frame.data for frame in of(0x705, frames)} == {b"\x05"}
    assert bench.ask(0x2104, 1) == b""


@pytest.mark.parametrize(("verb", "flags"), [("overheated", 0x01), ("emergency_stop", 0x10)])
def test_a_fault_is_in_the_flags_and_the_power_stage_is_off(verb: str, flags: int) -> None:
    bench = Bench()
    bench.run(1000)
    assert bench.ask(0x2112, 0) == bytes.fromhex("4B 12 21 00 00 00 00 00")
    bench.node.fault(verb, bench.now_ns, SECOND)
    assert bench.ask(0x2112, 0) == bytes((0x4B, 0x12, 0x21, 0, flags, 0, 0, 0))
    assert bench.ask(0x2111, 0)[4:6] == b"\x09\0"
    bench.run(1000)
    assert bench.ask(0x2112, 0)[4:6] == bytes(2)


def test_sdo_deaf_answers_no_request_and_beats_on() -> None:
    bench = Bench()
    bench.run(1000)
    bench.node.fault("sdo_deaf", bench.now_ns, SECOND)
    assert bench.ask(0x2104, 1) == b""
    assert of(0x705, bench.run(500))
    bench.run(500)
    assert bench.ask(0x2104, 1)[0] == 0x43


@pytest.mark.parametrize("mode", ["canopen", "minican"])
@pytest.mark.parametrize("verb", ["off", "unplug"])
def test_without_power_it_is_silent_and_comes_back_at_0(mode: str, verb: str) -> None:
    bench = Bench(mode=mode, source="variable")
    bench.run(5011)
    bench.node.fault(verb, bench.now_ns, SECOND)
    frames = bench.run(3000)
    assert frames[0].stamp_ns > 6 * SECOND + START_NS
    assert pair(of(0x185, frames)[0])[0] == pytest.approx(0, abs=11)


@pytest.mark.parametrize("mode", ["canopen", "minican"])
def test_garbage_is_random_payloads_under_the_same_identifiers(mode: str) -> None:
    bench = Bench(mode=mode, source="variable")
    known = {frame.identifier for frame in bench.run(1000)}
    bench.node.fault("garbage", bench.now_ns)
    frames = bench.run(1000)
    assert {frame.identifier for frame in frames} == known
    pdos = [frame.data for frame in frames if frame.identifier < 0x700]
    assert len(set(pdos)) == len(pdos)


@pytest.mark.parametrize("mode", ["canopen", "minican"])
def test_delayed_is_late_by_200_ms(mode: str) -> None:
    bench = Bench(mode=mode, source="variable")
    bench.node.fault("delayed", 0)
    assert 600 * MS < bench.run(1000)[0].stamp_ns < 602 * MS


@pytest.mark.parametrize("mode", ["canopen", "minican"])
def test_commands_are_not_obeyed(mode: str) -> None:
    frames = Bench(mode=mode, source="variable").run(1000)
    bench = Bench(mode=mode, source="variable")
    bench.bus.send([CanFrame(0x200 + NODE, bytes.fromhex("E8030000 E8030000"))], 0)
    assert [frame.data for frame in bench.run(1000)] == [frame.data for frame in frames]


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"node": 128}, "node 128"),
        ({"channel": 0}, "channel 0"),
        ({"encoder": "resolver"}, "encoder 'resolver': there are quadrature and brushless"),
        ({"mode": "minican"}, "has no SDO"),
        ({"mode": "minican", "source": "variable", "variable": 5}, "variable 5"),
        ({"counts_per_turn": 0.5}, "counts_per_turn 0.5"),
        ({"period_ms": 0}, "period_ms 0"),
        ({"heartbeat_ms": -1}, "heartbeat_ms -1"),
    ],
)
def test_impossible_options_are_refused(options: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        RoboteqOptions(**options)
