from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import isfinite, nan, tau
from random import Random
from struct import pack
from typing import Any

from pytest import approx, mark, raises

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import Level, State
from echogrid.drivers.moteus import QUERY, Moteus
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole

MS = 1_000_000
NODE = 9
ROLE = WheelRole("left", fastest=20.0)
BOOTED_MS = 100_000


def reply(
    turns: float,
    rate: float = 0.0,
    milliseconds: int | None = None,
    *,
    mode: int = 0,
    fault: int = 0,
    celsius: int = 35,
    validity: int = 0b11,
) -> bytes:
    """24 V; None: firmware that does not count milliseconds."""
    counter = b"\x31\x70\x01" if milliseconds is None else b"\x29\x70" + pack("<i", milliseconds)
    state = bytes((0x21, 0, mode, 0x2E, 1)) + pack("<ff", turns, rate)
    data = state + bytes((0x23, 0x0D, 48, celsius, fault, 0x21, 0x58, validity)) + counter
    return data.ljust(32, b"\x50")


def frame(data: bytes, stamp_ns: int) -> CanFrame:
    return CanFrame(NODE << 8, data, extended=True, stamp_ns=stamp_ns, fd=True)


class Bench:
    """The driver and a controller that is played by hand: each reply comes 1 ms after its request."""

    def __init__(self, role: WheelRole = ROLE, **settings: Any) -> None:
        self.device = Moteus(role, Moteus.Settings(**{"node": NODE, **settings}))
        self.now_ns = BOOTED_MS * MS
        self.sent: list[CanFrame] = []
        self.readings: list[WheelReading] = []
        self.counter = True

    def say(self, turns: float, rate: float = 0.0, **more: Any) -> list[tuple[float, bool]]:
        """Answer the next request; angle in turns and flag of the readings."""
        self.request()
        self.now_ns += MS
        uptime = more.pop("milliseconds", self.now_ns // MS - BOOTED_MS if self.counter else None)
        return self.hear(frame(reply(turns, rate, uptime, **more), self.now_ns))

    def request(self) -> CanFrame:
        """The next one. Time goes on to when the device wants to be called."""
        for _ in range(3):
            step = self.device.step(self.now_ns, ())
            self.sent += step.send
            if step.send:
                return step.send[0]
            self.now_ns = max(self.now_ns, step.deadline_ns)
        raise AssertionError("it asks for nothing")

    def hear(self, *frames: CanFrame) -> list[tuple[float, bool]]:
        step = self.device.step(self.now_ns, frames)
        self.sent += step.send
        given = [each for each in step.readings if isinstance(each, WheelReading)]
        self.readings += given
        return [(round(each.angle / tau, 4), each.discontinuity) for each in given]

    def wait(self, for_ns: int) -> None:
        self.now_ns += for_ns

    @property
    def state(self) -> State:
        return self.device.health(self.now_ns).state

    @property
    def message(self) -> str:
        return self.device.health(self.now_ns).message

    @property
    def counts(self) -> Counter[str]:
        return Counter(self.device.health(self.now_ns).counts)


def test_it_asks_for_registers_with_its_own_identifier_by_can_fd() -> None:
    request = Bench().request()
    assert request == CanFrame(0x8009, QUERY, extended=True, fd=True)
    assert Bench(prefix=0x123).request().identifier == 0x0123_8009


def test_it_asks_every_20_ms() -> None:
    bench, heard_ns = Bench(), []
    for turn in range(10):
        bench.say(turn * 0.01)
        heard_ns.append(bench.now_ns)
    assert {later - sooner for sooner, later in pairwise(heard_ns)} == {20 * MS}
    assert bench.counts["missing replies"] == 0


def test_nothing_but_its_request_is_ever_sent() -> None:
    bench = Bench()
    for turn in range(50):
        bench.say(turn * 0.01)
    bench.device.lost(bench.now_ns)
    bench.say(0.5)
    assert {sent.data for sent in bench.sent} == {QUERY}
    assert not hasattr(bench.device, "parting")


def test_a_reply_makes_a_reading_with_its_own_stamp() -> None:
    bench = Bench(replace(ROLE, gear=-2.0))
    bench.request()
    data = reply(-1.5, 0.25, 7)
    bench.now_ns += 5 * MS
    bench.hear(frame(data, bench.now_ns - 2 * MS))
    (reading,) = bench.readings
    assert (reading.stamp_ns, reading.wheel, reading.raw) == (bench.now_ns - 2 * MS, "left", data)
    assert (reading.angle, reading.rate) == (approx(1.5 * tau / 2), approx(-0.25 * tau / 2))
    assert (bench.state, bench.message) == (State.WELL, "turning counted")


def test_only_one_request_is_open() -> None:
    bench = Bench()
    bench.request()
    for _ in range(49):
        bench.wait(MS)
        assert bench.device.step(bench.now_ns, ()).send == ()
    bench.wait(MS)
    assert bench.device.step(bench.now_ns, ()).send == ()
    assert bench.counts["missing replies"] == 1
    bench.wait(250 * MS)
    assert len(bench.device.step(bench.now_ns, ()).send) == 1


def test_a_reply_that_comes_too_late_is_not_read() -> None:
    bench = Bench()
    bench.request()
    bench.wait(60 * MS)
    bench.device.step(bench.now_ns, ())
    bench.wait(100 * MS)
    assert bench.hear(frame(reply(1.0, 0.0, 5), bench.now_ns)) == []
    assert (bench.counts["unasked replies"], bench.state) == (1, State.STALLED)
    assert bench.say(1.0) == [(1.0, False)]
    assert bench.state is State.WELL


def test_without_replies_it_is_missing_and_the_message_says_what_to_check() -> None:
    bench = Bench()
    assert bench.state is State.MISSING
    bench.say(1.0)
    bench.wait(501 * MS)
    assert (bench.state, bench.device.health(bench.now_ns).level) == (State.MISSING, Level.ERROR)
    assert "moteus 9" in bench.message
    assert "CAN-FD at 1 and 5 Mbit/s" in bench.message


def test_no_position_is_no_position() -> None:
    bench = Bench()
    bench.say(1.0)
    for _ in range(30):
        assert bench.say(nan, nan) == []
    assert bench.state is State.FAULTY
    assert "encoder of source 0" in bench.message
    assert bench.say(3.0) == [(1.0, True)]


@mark.parametrize(
    ("source", "validity", "known"), [(0, 0b10, True), (0, 0b1100, False), (1, 0b1100, True), (2, 0x10, True)]
)
def test_the_encoder_of_the_output_must_be_at_work(source: int, validity: int, known: bool) -> None:
    assert bool(Bench(source=source).say(1.0, validity=validity)) is known


def test_a_fault_is_told_by_name_and_the_position_goes_on() -> None:
    bench = Bench()
    assert bench.say(1.0, mode=1, fault=33) == [(1.0, False)]
    assert bench.state is State.FAILED
    assert bench.message.startswith("motor driver fault (33, supply 24.0 V)")
    bench.say(1.0, mode=1, fault=77)
    assert bench.message.startswith("fault (77")


def test_a_code_without_a_fault_is_a_limit_and_no_trouble() -> None:
    bench = Bench()
    bench.say(1.0, mode=10, fault=99)
    assert bench.state is State.WELL


def test_a_warm_board_is_hot() -> None:
    bench = Bench()
    bench.say(1.0, celsius=70)
    assert bench.state is State.WELL
    bench.say(1.0, celsius=71)
    assert (bench.state, bench.message[:13]) == (State.HOT, "board at 71 C")


def test_a_restart_is_no_motion() -> None:
    bench = Bench()
    bench.say(100.3)
    bench.wait(700 * MS)
    assert bench.say(0.3, milliseconds=100) == [(100.3, True)]
    assert bench.say(0.4, milliseconds=120) == [(100.4, False)]


def test_a_restart_near_to_where_it_was_shows_by_its_counter() -> None:
    bench = Bench()
    for _ in range(10):
        bench.say(0.3)
    assert bench.say(0.2, milliseconds=5) == [(0.3, True)]


@mark.parametrize("lost", [False, True])
def test_a_silence_in_which_it_has_not_restarted_loses_nothing(lost: bool) -> None:
    bench = Bench()
    bench.say(5.0)
    if lost:
        bench.device.lost(bench.now_ns)
        assert bench.state is State.MISSING
    bench.wait(60_000 * MS)
    assert bench.say(17.0) == [(17.0, False)]


@mark.parametrize("lost", [False, True])
def test_without_its_counter_a_silence_is_a_discontinuity(lost: bool) -> None:
    bench = Bench()
    bench.counter = False
    bench.say(5.0)
    assert bench.say(5.1) == [(5.1, False)]
    if lost:
        bench.device.lost(bench.now_ns)
    bench.wait(MS if lost else 400 * MS)
    assert bench.say(5.2) == [(5.1, True)]
    assert bench.say(5.3) == [(5.2, False)]


def test_a_single_wild_position_is_dropped_and_a_lasting_one_flagged() -> None:
    bench = Bench()
    bench.say(1.0)
    assert bench.say(50.0) == []
    assert bench.say(1.01) == [(1.01, False)]
    assert bench.say(50.0) == []
    assert bench.say(50.0) == [(1.01, True)]


def test_many_turns_are_told_as_finely_as_single_precision_is() -> None:
    bench, turns = Bench(), 3_000_000.0
    for _ in range(20):
        ((angle, jumped),) = bench.say(turns, 1.0)
        assert (angle, jumped) == (turns, False)
        turns += 0.25
    assert bench.say(float(1 << 23)) == []
    assert bench.counts["positions out of range"] == 1


def test_a_silence_counts_also_if_the_first_reply_after_it_is_not_believed() -> None:
    bench = Bench()
    bench.counter = False
    bench.say(40.0)
    bench.wait(500 * MS)
    bench.say(0.0, nan)
    assert bench.say(0.1) == [(40.0, True)]


def test_duplicates_and_older_stamps_are_no_motion() -> None:
    bench = Bench()
    bench.say(1.0)
    again = frame(reply(1.0, 0.0, bench.now_ns // MS - BOOTED_MS), bench.now_ns)
    assert bench.hear(again, again) == []
    bench.request()
    assert bench.hear(replace(again, stamp_ns=again.stamp_ns - 30 * MS)) == []
    assert (bench.counts["unasked replies"], bench.counts["positions out of order"]) == (2, 1)
    assert bench.state is State.WELL


@mark.parametrize(
    ("wrong", "name"),
    [
        (replace(frame(reply(9.0), 1), fd=False, data=bytes(8)), "classic frames"),
        (replace(frame(reply(9.0), 1), identifier=0xA00), "foreign frames"),
        (replace(frame(reply(9.0), 1), identifier=0x901), "foreign frames"),
        (frame(bytes.fromhex("2404000A005000000170FF230D181400"), 1), "replies to others"),
        (frame(b"", 1), "replies to others"),
        (frame(reply(9.0)[:20], 1), "malformed replies"),
    ],
)
def test_frames_that_tell_nothing_are_counted_and_the_request_stays_open(wrong: CanFrame, name: str) -> None:
    bench = Bench()
    bench.request()
    assert bench.hear(wrong) == []
    assert bench.counts[name] == 1
    assert bench.hear(frame(reply(2.0, 0.0, 7), bench.now_ns)) == [(2.0, False)]


def test_replies_without_a_meaning_are_told() -> None:
    bench = Bench()
    bench.request()
    bench.hear(frame(b"\xff" * 32, bench.now_ns))
    assert (bench.state, "0x900" in bench.message) == (State.GARBLED, True)


def test_a_jumping_position_is_faulty() -> None:
    bench = Bench()
    for turn in range(60):
        bench.say(1000.0 * turn)
    assert bench.state is State.FAULTY
    assert "one moteus 9 only" in bench.message


def test_it_cannot_be_where_nothing_may_be_sent() -> None:
    with raises(ValueError, match="a moteus says nothing unless it is asked"):
        Moteus(replace(ROLE, listen_only=True), Moteus.Settings())


@mark.parametrize(
    ("settings", "text"),
    [
        ({"node": 0}, "node is 0: expected 1 to 127"),
        ({"node": 128}, "node is 128"),
        ({"prefix": 0x2000}, "prefix is 8192"),
        ({"poll_ms": 1}, "poll_ms is 1"),
        ({"source": 3}, "source is 3"),
        ({"hottest_c": 200.0}, "hottest_c is 200.0"),
    ],
)
def test_impossible_settings_are_refused_by_name(settings: dict[str, Any], text: str) -> None:
    with raises(ValueError, match=text):
        Moteus.Settings(**settings)


def bent(random: Random, data: bytes) -> bytes:
    """With some bytes changed."""
    changed = bytearray(data)
    for _ in range(random.randrange(1, 4)):
        changed[random.randrange(len(changed))] = random.randrange(256)
    return bytes(changed)


def random_frame(random: Random, now_ns: int) -> CanFrame:
    """Mostly to us; now and then late, cut short, bent, of another's, or noise."""
    turns = random.choice((random.gauss(0.0, 0.3), random.uniform(-1e6, 1e6), nan, float("inf"), 1e38))
    uptime = random.choice((now_ns // MS, now_ns // MS, None, random.randrange(-(1 << 31), 1 << 31)))
    true = reply(turns, random.gauss(0.0, 2.0), uptime and uptime % (1 << 31), mode=random.randrange(2))
    make: Callable[[], bytes] = random.choice(
        (
            lambda: true,
            lambda: true,
            lambda: bent(random, true),
            lambda: true[: random.randrange(33)],
            lambda: random.randbytes(random.choice((0, 1, 8, 12, 32, 64))),
        )
    )
    identifier = NODE << 8 if random.random() < 0.9 else random.randrange(1 << 29)
    stamp_ns = now_ns - random.choice((0, 0, 0, random.randrange(50 * MS)))
    return CanFrame(identifier, make(), True, random.random() < 0.02, stamp_ns, random.random() < 0.95)


def test_random_frames_raise_nothing_and_turn_no_wheel_faster_than_it_can() -> None:
    device, random, now_ns = Moteus(ROLE, Moteus.Settings(node=NODE)), Random(5), 1000 * MS
    wheels: list[WheelReading] = []
    for number in range(100_000):
        now_ns += random.choice((0, 1, random.randrange(20 * MS), random.randrange(700 * MS)))
        given = device.step(now_ns, [random_frame(random, now_ns)]).readings
        wheels += [reading for reading in given if isinstance(reading, WheelReading)]
        if number % 1000 == 0:
            device.lost(now_ns)
        assert device.health(now_ns).message
    assert len(wheels) > 50
    for old, new in pairwise(wheels):
        assert isfinite(new.angle) and isfinite(new.rate)
        reach = 0.0 if new.discontinuity else ROLE.fastest * ((new.stamp_ns - old.stamp_ns) * 1e-9 + 0.02)
        assert abs(new.angle - old.angle) <= reach + 1e-5 + abs(old.angle) * 1e-6
