from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from math import isfinite, tau
from random import Random
from struct import pack
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from pytest import approx, mark, raises

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.drivers.device import State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.roboteq import LISTEN_ONLY, Roboteq, decode_variables
from echogrid.drivers.roboteq_flags import FAULTS, STATUS, flag_names
from echogrid.drivers.roboteq_settings import COUNTERS, RoboteqSettings
from echogrid.drivers.role import WheelRole

MS = 1_000_000
SECOND = 1000 * MS
NODE = 3
PER_TURN = 2000.0
ROLE = WheelRole("left", fastest=100.0)
START = 10 * SECOND
OPERATIONAL, PRE_OPERATIONAL, STOPPED, BOOT = 5, 0x7F, 4, 0


def roboteq(role: WheelRole = ROLE, **settings: Any) -> Roboteq:
    return Roboteq(role, RoboteqSettings(**{"node": NODE, "counts_per_turn": PER_TURN, **settings}))


def beat(stamp_ns: int, state: int = OPERATIONAL) -> CanFrame:
    return CanFrame(0x700 + NODE, bytes((state,)), stamp_ns=stamp_ns)


def variables(stamp_ns: int, first: int, second: int = 0, number: int = 1) -> CanFrame:
    return CanFrame(0x80 + 0x100 * number + NODE, pack("<ii", first, second), stamp_ns=stamp_ns)


def reply(stamp_ns: int, text: str) -> CanFrame:
    return CanFrame(0x580 + NODE, bytes.fromhex(text), stamp_ns=stamp_ns)


def only_wheels(readings: Sequence[object]) -> list[WheelReading]:
    return [reading for reading in readings if isinstance(reading, WheelReading)]


def listened(device: Roboteq, *frames: CanFrame) -> list[WheelReading]:
    given = [reading for each in frames for reading in device.step(each.stamp_ns, [each]).readings]
    return only_wheels(given)


def told(readings: list[WheelReading]) -> list[tuple[int, bool]]:
    return [(round(reading.angle / tau * PER_TURN), reading.discontinuity) for reading in readings]


def count(device: Roboteq, name: str) -> int:
    return device.health(0).counts.get(name, 0)


class Bench:
    """A controller played by hand: its heartbeat, and what it says to each object that is asked for."""

    def __init__(self, role: WheelRole = ROLE, **settings: Any) -> None:
        self.device = roboteq(role, **settings)
        self.now_ns = START
        self.objects: dict[tuple[int, int], bytes] = {(0x2104, 1): bytes(4), (0x2111, 0): bytes(2)}
        self.objects[0x2112, 0] = bytes(2)
        self.beats = True
        self.reply_ns = MS
        self.sent: list[tuple[int, CanFrame]] = []
        self.readings: list[WheelReading] = []
        self._due: list[CanFrame] = []

    def counts(self, count: int) -> None:
        """What its first encoder counts from now on."""
        self.objects[0x2104, 1] = pack("<i", count)

    def say(self, frame: CanFrame) -> None:
        """Say something at once."""
        self._due.append(replace(frame, stamp_ns=self.now_ns))

    def run(self, milliseconds: int) -> State:
        """Go on so long, a step each millisecond; how it is then."""
        for _ in range(milliseconds):
            self.now_ns += MS
            if self.beats and self.now_ns % (100 * MS) == 0:
                self._due.append(beat(self.now_ns))
            heard = [frame for frame in self._due if frame.stamp_ns <= self.now_ns]
            self._due = [frame for frame in self._due if frame.stamp_ns > self.now_ns]
            step = self.device.step(self.now_ns, heard)
            self.readings += only_wheels(step.readings)
            for frame in step.send:
                self.sent.append((self.now_ns, frame))
                self._answer(frame)
        return self.device.health(self.now_ns).state

    @property
    def message(self) -> str:
        return self.device.health(self.now_ns).message

    def asked(self, index: int, sub: int) -> list[int]:
        """When an object was asked for."""
        request = bytes((0x40, index & 0xFF, index >> 8, sub, 0, 0, 0, 0))
        return [at_ns for at_ns, frame in self.sent if frame == CanFrame(0x600 + NODE, request)]

    def _answer(self, request: CanFrame) -> None:
        key = request.data[1] | request.data[2] << 8, request.data[3]
        value = self.objects.get(key)
        if value == b"":
            return
        payload = b"\x80" + request.data[1:4] + pack("<I", 0x06020000)
        if value is not None:
            command = 0x43 | 4 - len(value) << 2
            payload = bytes((command,)) + request.data[1:4] + value.ljust(4, b"\0")
        self._due.append(CanFrame(0x580 + NODE, payload, stamp_ns=self.now_ns + self.reply_ns))


# Asked for


def test_its_absolute_counter_is_asked_for_each_20_ms_once_it_is_heard() -> None:
    bench = Bench()
    bench.beats = False
    bench.run(300)
    assert bench.sent == []
    bench.beats = True
    bench.run(1000)
    asked = bench.asked(0x2104, 1)
    assert asked[0] == START + 400 * MS
    assert {later - sooner for sooner, later in pairwise(asked)} == {20 * MS}
    assert bench.sent[0][1] == CanFrame(0x603, bytes.fromhex("40 04 21 01 00 00 00 00"))


def test_a_count_becomes_an_angle_at_a_time_between_request_and_reply() -> None:
    bench = Bench(replace(ROLE, gear=-2.0))
    bench.counts(1000)
    bench.run(101)
    (reading,) = bench.readings
    assert (reading.stamp_ns, reading.wheel) == (START + 100 * MS + MS // 2, "left")
    assert (reading.raw, reading.discontinuity) == (pack("<i", 1000), False)
    assert reading.angle == approx(-tau / 4)


@mark.parametrize(
    ("settings", "index", "sub"),
    [({"channel": 2}, 0x2104, 2), ({"encoder": "brushless"}, 0x2105, 1), ({"channel": 3}, 0x2104, 3)],
)
def test_channel_and_encoder_name_the_object(settings: dict[str, Any], index: int, sub: int) -> None:
    bench = Bench(**settings)
    bench.objects[index, sub] = pack("<i", -500)
    assert bench.run(300) is State.WELL
    assert told(bench.readings)[0] == (-500, False)
    assert bench.asked(index, sub)


def test_the_channels_of_a_controller_are_asked_one_after_the_other() -> None:
    benches = [Bench(channel=channel) for channel in (1, 2, 3)]
    for bench in benches:
        bench.run(150)
    first, second, third = (bench.sent[0][0] for bench in benches)
    assert first < second < third < first + 20 * MS


def test_no_setting_names_a_relative_counter() -> None:
    assert set(COUNTERS.values()) == {0x2104, 0x2105}
    for channel in (1, 2, 3):
        for encoder in COUNTERS:
            bench = Bench(channel=channel, encoder=encoder)
            bench.run(2500)
            assert {frame.data[1] for _, frame in bench.sent} <= {0x04, 0x05, 0x11, 0x12}


def test_the_maker_s_own_example_of_a_reply_is_understood_without_the_marks_of_the_standard() -> None:
    """581h 48 0D 21 02 90 01 00 00 (CANBus Networking Manual V2.0, p. 41): two bytes."""
    bench = Bench()
    bench.objects = {(0x2112, 0): bytes(2), (0x2111, 0): bytes(2), (0x2104, 1): b""}
    bench.run(100)
    bench.say(reply(0, "40 04 21 01 90 01 00 00"))
    bench.run(1)
    assert told(bench.readings) == [(400, False)]
    bench.objects = {(0x2112, 0): b"", (0x2111, 0): bytes(2), (0x2104, 1): pack("<i", 400)}
    while not bench.asked(0x2112, 0):
        bench.run(1)
    bench.say(reply(0, "48 12 21 00 04 00 00 00"))
    assert bench.run(30) is State.FAILED
    assert bench.message.startswith("undervoltage: ")


@mark.parametrize("direction", [1, -1])
def test_the_counter_wraps_in_both_directions(direction: int) -> None:
    bench = Bench()
    edge = (1 << 31) - 1 if direction > 0 else -(1 << 31)
    beyond = -(1 << 31) if direction > 0 else (1 << 31) - 1
    bench.counts(edge)
    bench.run(110)
    bench.counts(beyond)
    bench.run(20)
    assert told(bench.readings) == [(edge, False), (edge + direction, False)]


def test_a_lost_reply_loses_no_motion() -> None:
    bench = Bench()
    bench.run(200)
    bench.objects[0x2104, 1] = b""
    bench.run(40)
    bench.counts(4000)
    bench.run(400)
    assert told(bench.readings)[-1] == (4000, False)
    assert count(bench.device, "requests without a reply") == 1
    assert not any(reading.discontinuity for reading in bench.readings)


def test_a_restart_is_no_motion_and_it_is_asked_again_at_once() -> None:
    bench = Bench()
    bench.counts(90_000)
    bench.run(300)
    bench.objects[0x2104, 1] = b""
    bench.run(60)
    bench.say(beat(0, BOOT))
    bench.counts(30_000)
    bench.run(3)
    bench.counts(30_002)
    bench.run(20)
    assert told(bench.readings)[-3:] == [(90_000, False), (90_000, True), (90_002, False)]
    assert count(bench.device, "restarts") == 1


def test_a_pulled_cable_loses_no_motion_far_from_zero() -> None:
    bench = Bench()
    bench.counts(900_000)
    bench.run(300)
    bench.device.lost(bench.now_ns)
    assert bench.device.health(bench.now_ns).state is State.SILENT
    bench.now_ns += 1000 * MS
    bench.counts(905_000)
    bench.run(300)
    assert told(bench.readings)[-1] == (905_000, False)


def test_a_jump_that_no_wheel_can_do_is_flagged_once_it_stays() -> None:
    bench = Bench()
    bench.run(300)
    bench.counts(1_000_000)
    assert bench.run(100) is State.WELL
    assert told(bench.readings)[-1] == (0, False)
    assert count(bench.device, "discontinuities") == 1


def test_jumps_without_end_are_a_fault_that_names_the_settings() -> None:
    bench, random = Bench(), Random(1)
    for _ in range(100):
        bench.counts(random.randrange(-(1 << 31), 1 << 31))
        bench.run(20)
    assert bench.device.health(bench.now_ns).state is State.FAULTY
    assert "counts_per_turn" in bench.message


def test_a_refusal_is_told_with_its_object_and_what_to_do() -> None:
    bench = Bench(encoder="brushless")
    assert bench.run(300) is State.WRONG_DEVICE
    assert bench.message.startswith("2105h:1: no such object (0x06020000): ")
    assert 'source = "variable"' in bench.message
    bench.objects[0x2105, 1] = bytes(4)
    assert bench.run(30) is State.WELL


def test_older_firmware_without_flags_is_counted_all_the_same() -> None:
    bench = Bench()
    del bench.objects[0x2112, 0]
    assert bench.run(300) is State.WELL
    assert "flags not known: 2112h:0: no such object" in bench.message


def test_flags_of_one_byte_are_flags() -> None:
    bench = Bench()
    bench.objects[0x2112, 0] = b"\x02"
    assert bench.run(300) is State.FAILED
    assert bench.message.startswith("overvoltage")


def test_a_count_of_two_bytes_is_none() -> None:
    bench = Bench()
    bench.objects[0x2104, 1] = b"\1\2"
    assert bench.run(800) is State.STALLED
    assert bench.readings == []
    assert count(bench.device, "counts of a wrong length") > 10


def test_a_late_reply_is_not_believed_and_told() -> None:
    bench = Bench()
    bench.reply_ns = 200 * MS
    assert bench.run(1000) is State.STALLED
    assert bench.readings == []
    assert "ms late" in bench.message
    bench.reply_ns = 25 * MS
    assert bench.run(500) is State.WELL


def test_another_s_conversation_with_the_controller_is_not_ours() -> None:
    bench = Bench()
    bench.run(310)
    known = len(bench.readings)
    bench.objects = dict.fromkeys(bench.objects, b"")
    bench.run(20)
    for text in ("43 08 21 01 40 E2 01 00", "43 04 21 02 40 E2 01 00", "60 04 21 01 00 00 00 00"):
        bench.say(reply(0, text))
    bench.run(5)
    assert len(bench.readings) == known


def test_without_sdo_it_says_which_request_has_no_reply() -> None:
    bench = Bench()
    bench.objects = dict.fromkeys(bench.objects, b"")
    assert bench.run(1000) is State.STALLED
    assert "no reply to the request for 2104h:1" in bench.message
    assert "MiniCAN" in bench.message


def test_a_stopped_node_is_told() -> None:
    bench = Bench()
    bench.beats = False
    bench.objects = dict.fromkeys(bench.objects, b"")
    for _ in range(10):
        bench.say(beat(0, STOPPED))
        bench.run(100)
    assert bench.device.health(bench.now_ns).state is State.STALLED
    assert bench.message.endswith("it is stopped")


def test_a_missing_heartbeat_is_told_while_it_counts_on() -> None:
    bench = Bench()
    bench.run(300)
    bench.beats = False
    assert bench.run(600) is State.FAULTY
    assert "heartbeat" in bench.message
    assert len(bench.readings) > 35
    bench.beats = True
    assert bench.run(110) is State.WELL


def test_without_a_heartbeat_to_expect_it_asks_and_is_well() -> None:
    bench = Bench(heartbeat_ms=0)
    bench.beats = False
    assert bench.run(300) is State.WELL


@mark.parametrize("bit", FAULTS)
def test_a_fault_is_told_by_name_and_goes_with_it(bit: int) -> None:
    bench = Bench()
    bench.objects[0x2112, 0] = pack("<H", bit)
    assert bench.run(300) is (State.HOT if bit == 0x01 else State.FAILED)
    assert bench.message.startswith(f"{FAULTS[bit]}: ")
    assert len(bench.readings) > 5
    bench.objects[0x2112, 0] = bytes(2)
    assert bench.run(1100) is State.WELL


def test_several_faults_are_told_with_what_mends_them() -> None:
    bench = Bench()
    bench.objects[0x2112, 0] = pack("<H", 0x0211)
    assert bench.run(300) is State.FAILED
    expected = "overheat, emergency stop, flag 0x200: let it cool, load it less, release it"
    assert bench.message == expected


def test_its_status_is_told_by_name() -> None:
    bench = Bench()
    bench.objects[0x2111, 0] = pack("<H", 0x98)
    assert bench.run(300) is State.WELL
    assert bench.message == "turning counted; status: power stage off, stall, script running"
    assert len(bench.asked(0x2111, 0)) == 1
    bench.run(2000)
    assert len(bench.asked(0x2111, 0)) == 3


@given(st.integers(0, 0xFFFF))
def test_every_flag_has_a_name(flags: int) -> None:
    for known in (FAULTS, STATUS):
        names = flag_names(flags, known).split(", ") if flags else []
        assert len(names) == flags.bit_count()


# Listened to


def test_two_variables_are_in_a_tpdo_the_low_byte_first() -> None:
    """0x12345678 is sent as 78 56 34 12 (User Manual V1.8, p. 164)."""
    assert decode_variables(bytes.fromhex("78563412 C01DFEFF")) == (0x12345678, -123456)


@mark.parametrize("number", range(1, 9))
def test_a_variable_is_read_from_its_half_of_its_tpdo(number: int) -> None:
    device = roboteq(source="variable", variable=number)
    values = [0, 0]
    values[(number - 1) % 2] = 4242
    (reading,) = listened(device, variables(START, *values, number=(number + 1) // 2))
    assert told([reading]) == [(4242, False)]
    assert reading.stamp_ns == START


def test_a_variable_needs_nothing_to_be_sent() -> None:
    device = roboteq(replace(ROLE, listen_only=True), source="variable")
    for now_ns in range(START, START + SECOND, 100 * MS):
        step = device.step(now_ns, [beat(now_ns), variables(now_ns, 1)])
        assert (step.send, step.deadline_ns) == ((), NEVER_NS)
    assert device.health(START + SECOND).state is State.WELL


def test_a_bus_that_is_only_listened_to_refuses_requests_and_says_what_to_do() -> None:
    with raises(ValueError, match='source = "variable"') as refusal:
        roboteq(replace(ROLE, listen_only=True))
    assert str(refusal.value) == LISTEN_ONLY


@mark.parametrize("direction", [1, -1])
def test_a_variable_wraps_in_both_directions(direction: int) -> None:
    edge = (1 << 31) - 1 if direction > 0 else -(1 << 31)
    beyond = -(1 << 31) if direction > 0 else (1 << 31) - 1
    frames = [variables(START, edge), variables(START + 20 * MS, beyond)]
    given = listened(roboteq(source="variable"), *frames)
    assert told(given) == [(edge, False), (edge + direction, False)]


def test_duplicates_are_no_motion_and_swapped_frames_end_where_they_should() -> None:
    steps = [(0, 10), (0, 10), (20, 14), (30, 12), (40, 16)]
    frames = [variables(START + ms * MS, count) for ms, count in steps]
    given = listened(roboteq(source="variable"), *frames)
    assert told(given) == [(10, False), (10, False), (14, False), (12, False), (16, False)]


def test_a_late_stamp_is_dropped() -> None:
    device = roboteq(source="variable")
    frames = variables(START + 10 * MS, 10), variables(START, 8)
    assert told(listened(device, *frames)) == [(10, False)]
    assert count(device, "counts out of order") == 1


def test_a_restart_without_a_boot_up_message_is_seen_by_its_pause() -> None:
    device = roboteq(source="variable")
    given = listened(device, beat(START), variables(START, 5000), variables(START + 400 * MS, 20))
    assert told(given) == [(5000, False), (5000, True)]


def test_its_boot_up_message_is_believed_where_nothing_else_shows_the_restart() -> None:
    device = roboteq(source="variable")
    frames = [variables(START + n * 20 * MS, 30 + n) for n in range(10)]
    listened(device, *frames)
    given = listened(device, beat(START + 200 * MS, BOOT), variables(START + 210 * MS, 0))
    assert told(given) == [(39, True)]


@mark.parametrize(
    ("wrong", "name"),
    [
        (variables(START, 5, number=2), "foreign frames"),
        (replace(variables(START, 5), identifier=0x180 + NODE + 1), "foreign frames"),
        (replace(variables(START, 5), data=bytes(7)), "variable frames of a wrong length"),
        (replace(variables(START, 5), extended=True), "extended or remote frames"),
        (replace(variables(START, 5), remote=True, data=b""), "extended or remote frames"),
        (CanFrame(0x700 + NODE, b"", stamp_ns=START), "heartbeat frames of a wrong length"),
    ],
)
def test_frames_that_tell_nothing_are_counted(wrong: CanFrame, name: str) -> None:
    device = roboteq(source="variable")
    assert listened(device, wrong) == []
    assert count(device, name) == 1
    assert device.health(START).state is State.SILENT


def test_a_node_that_waits_for_its_master_is_told() -> None:
    device = roboteq(source="variable")
    listened(device, beat(START, PRE_OPERATIONAL))
    health = device.health(START + MS)
    assert health.state is State.STALLED
    assert health.message.startswith("it is pre-operational")


def test_a_tpdo_that_is_not_sent_is_named() -> None:
    device = roboteq(source="variable", variable=3)
    listened(device, beat(START))
    health = device.health(START + MS)
    assert (health.state, "CTPS 2" in health.message) == (State.STALLED, True)


def test_a_variable_of_16_bits_is_hinted_at_where_it_may_be() -> None:
    device, random = roboteq(source="variable", variable=5), Random(1)
    frames = [
        variables(START + n * 20 * MS, random.randrange(-(1 << 31), 1 << 31), number=3) for n in range(60)
    ]
    listened(device, *frames, beat(START + 1200 * MS))
    assert "VAR1 to VAR4" in device.health(START + 1200 * MS).message


def test_it_is_silent_half_a_second_after_the_last_frame() -> None:
    device = roboteq(source="variable")
    listened(device, beat(START), variables(START, 0))
    assert device.health(START + 400 * MS).state is State.WELL
    assert device.health(START + 501 * MS).state is State.SILENT
    assert "node 3" in device.health(START + 501 * MS).message


# Settings


@mark.parametrize(
    ("settings", "text"),
    [
        ({"node": 0}, "node is 0: expected 1 to 127"),
        ({"channel": 4}, "channel is 4: expected 1 to 3"),
        ({"variable": 9}, "variable is 9: expected 1 to 8"),
        ({"counts_per_turn": 0.0}, "counts_per_turn is 0.0"),
        ({"poll_ms": 1}, "poll_ms is 1: expected 5 to 200"),
        ({"heartbeat_ms": 5}, "heartbeat_ms is 5: expected 10 to 10000"),
    ],
)
def test_impossible_settings_are_refused_by_name(settings: dict[str, Any], text: str) -> None:
    with raises(ValueError, match=text):
        RoboteqSettings(**{"counts_per_turn": PER_TURN, **settings})


def test_two_wheels_may_share_a_node_but_not_a_counter() -> None:
    settings = RoboteqSettings(PER_TURN)
    assert replace(settings, channel=2).counter != settings.counter
    assert replace(settings, variable=2).counter == settings.counter
    variable = replace(settings, source="variable")
    assert variable.counter == "VAR1 of node 1"
    assert replace(variable, variable=2).counter != variable.counter


# Noise


def noise(random: Random, now_ns: int) -> CanFrame:
    """Mostly of the device's own identifiers; now and then late, short, or another's."""
    identifier = random.choice((0x180, 0x580, 0x580, 0x700)) + random.choice((NODE, NODE, NODE, 9))
    data = random.randbytes(8 if random.random() < 0.9 else random.randrange(9))
    if identifier == 0x580 + NODE and random.random() < 0.7:
        data = bytes((random.choice((0x43, 0x40, 0x80)), 0x04, 0x21, 1)) + random.randbytes(4)
    if identifier == 0x700 + NODE:
        data = data[:1]
    stamp_ns = now_ns - random.choice((0, 0, 0, 0, random.randrange(50 * MS)))
    return CanFrame(identifier, data, random.random() < 0.05, random.random() < 0.05, stamp_ns)


@mark.parametrize("source", ["sdo", "variable"])
def test_random_frames_raise_nothing_and_turn_no_wheel_faster_than_it_can(source: str) -> None:
    wheels = told_of_noise(source, 100_000)
    assert len(wheels) > 50
    for old, new in pairwise(wheels):
        assert isfinite(new.angle)
        reach = 0.0 if new.discontinuity else ROLE.fastest * ((new.stamp_ns - old.stamp_ns) * 1e-9 + 0.02)
        assert abs(new.angle - old.angle) <= reach + 1e-3


def told_of_noise(source: str, frames: int) -> list[WheelReading]:
    """What the driver makes of so many frames."""
    random, now_ns, device = Random(5), 1000 * MS, roboteq(source=source)
    wheels: list[WheelReading] = []
    for number in range(frames):
        now_ns += random.choice((0, 1, random.randrange(20 * MS), random.randrange(700 * MS)))
        wheels += only_wheels(device.step(now_ns, [noise(random, now_ns)]).readings)
        if number % 1000 == 0:
            device.lost(now_ns)
        assert device.health(now_ns).message
    return wheels
