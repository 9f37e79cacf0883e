from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import isnan

from hypothesis import given, settings
from hypothesis.strategies import binary, integers, lists, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.device import Level, State
from echogrid.drivers.modbus import quiet_ns
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import Call, RangerRole, Slot
from echogrid.drivers.urm_modbus import Urm12, Urm13, Urm14, Urm15, address_change

from .modbus_bench import BYTE_NS, MS, TURNAROUND_NS, Bench, Slave, sealed

SPEED = 343.0
SLOT = Slot(400 * MS, 60 * MS)
MODELS = {"urm12": Urm12, "urm13": Urm13, "urm14": Urm14, "urm15": Urm15}
PRODUCTS = {"urm12": 1, "urm13": 3, "urm14": 2, "urm15": 5}
REACH = {"urm12": 15.0, "urm13": 9.0, "urm14": 1.5, "urm15": 5.0}
NOTHING = 0xFFFF


def role(farthest: float, name: str = "front") -> RangerRole:
    return RangerRole(name, 0.05, farthest, SLOT, SPEED)


def urm(address: int = 0x0C, product: int = 2, distance: int = NOTHING, control: int = 4) -> Slave:
    return Slave(address, {0: product, 1: 0x10, 5: distance, 6: 215, 7: 0, 8: control})


def bench(name: str = "urm14", slave: Slave | None = None, **keys: object) -> tuple[Bench, Slave]:
    chosen = MODELS[name].Settings(**keys)
    slave = slave or urm(chosen.address, PRODUCTS[name])
    return Bench([MODELS[name](role(REACH[name]), chosen)], [slave]), slave


def obeys_at_once(slave: Slave) -> None:
    """Let it clear its trigger bit itself."""

    def spoilt(frame: bytes) -> bytes:
        slave.registers[8] &= ~8
        return frame

    slave.spoilt = spoilt


def test_it_is_asked_who_it_is_and_told_to_ping_in_its_turn() -> None:
    line, slave = bench()
    line.run(300 * MS)
    asked = [bytes.fromhex(text) for text in ("0C 03 00 00 00 02", "0C 03 00 05 00 04", "0C 06 00 08 00 0C")]
    assert [frame[:-2] for _, frame in line.sent] == [*asked, asked[1]]
    assert line.sent[2][0] == 60 * MS
    assert slave.written == [(8, 0x0C)]


def test_one_that_pings_by_itself_is_told_to_wait_and_no_other_is_written_to() -> None:
    line, slave = bench(slave=urm(control=0x00))
    line.run(50 * MS)
    assert slave.written == [(8, 0x04)]
    line, slave = bench(slave=urm(control=0x04))
    line.run(50 * MS)
    assert slave.written == []


@mark.parametrize(("farthest", "control"), [(1.5, 0x14), (1.6, 0x04), (9.0, 0x04)])
def test_a_urm13_takes_the_short_range_if_no_more_is_asked_for(farthest: float, control: int) -> None:
    slave = urm(0x0D, 3, control=0x06)
    Bench([Urm13(role(farthest), Urm13.Settings())], [slave]).run(50 * MS)
    assert slave.written == [(8, control)]


@mark.parametrize(
    ("name", "counts", "metres"),
    [("urm14", 12345, 1.2345), ("urm13", 123, 1.23), ("urm12", 123, 1.23), ("urm15", 1234, 1.234)],
)
def test_each_model_has_its_unit_and_the_moment_its_uncertainty(
    name: str, counts: int, metres: float
) -> None:
    line, slave = bench(name)
    slave.registers[5] = counts
    obeys_at_once(slave)
    line.run(450 * MS)
    (reading,) = line.readings
    assert (reading.outcome, reading.distance) == (Outcome.ECHO, approx(metres))
    sent_ns, reply_ns = 60 * MS + 8 * BYTE_NS, TURNAROUND_NS + 8 * BYTE_NS
    end_ns = 60 * MS + 8 * BYTE_NS + reply_ns
    fired_ns = reading.stamp_ns - round(metres / SPEED * 1e9)
    assert fired_ns == approx((sent_ns + end_ns) / 2, abs=MS // 2)
    assert reading.stamp_error_ns == approx((end_ns - sent_ns) / 2, abs=MS // 2)
    assert reading.raw[:3] == bytes((slave.address, 3, 8))


def test_a_urm13_in_millimetres_is_told_so() -> None:
    line, slave = bench("urm13", unit_mm=1.0)
    slave.registers[5] = 1234
    obeys_at_once(slave)
    line.run(250 * MS)
    assert line.readings[0].distance == approx(1.234)


def test_a_distance_beyond_the_model_s_range_is_doubted_because_its_unit_may_be_another() -> None:
    line, slave = bench("urm13")
    slave.registers[5] = 1234
    obeys_at_once(slave)
    line.run(250 * MS)
    reason = "1234 would be 12.34 m, beyond its range: is its unit another?"
    assert [reading.reason for reading in line.readings] == [reason]
    health = line.line.devices[0].health(line.now_ns)
    assert (health.state, health.message) == (State.FAULTY, f"invalid reading: {reason}")
    assert health.counts["set-ups"] == 1


@mark.parametrize(
    ("counts", "outcome"),
    [
        (NOTHING, Outcome.NO_ECHO),
        (0, Outcome.TOO_CLOSE),
        (999, Outcome.TOO_CLOSE),
        (1000, Outcome.ECHO),
        (14_999, Outcome.ECHO),
        (15_000, Outcome.NO_ECHO),
        (16_400, Outcome.NO_ECHO),
        (16_600, Outcome.INVALID),
    ],
)
def test_every_count_has_its_meaning(counts: int, outcome: Outcome) -> None:
    line, slave = bench()
    slave.registers[5] = counts
    line.run(250 * MS)
    (reading,) = line.readings
    assert reading.outcome is outcome
    assert isnan(reading.distance) == (outcome is not Outcome.ECHO)


def test_a_urm12_says_0_when_it_hears_nothing() -> None:
    line, slave = bench("urm12")
    slave.registers[5] = 0
    line.run(500 * MS)
    assert [reading.outcome for reading in line.readings] == [Outcome.NO_ECHO]


def test_what_no_echo_is_can_be_set() -> None:
    line, slave = bench(no_echo=(0, 15_001))
    slave.registers[5] = 0
    line.run(250 * MS)
    assert line.readings[0].outcome is Outcome.NO_ECHO


@mark.parametrize("name", MODELS)
def test_a_farther_reach_than_the_model_s_is_refused(name: str) -> None:
    with raises(ValueError, match=f"max_m is 16.0: expected 0.0 to {REACH[name]}"):
        MODELS[name](role(16.0), MODELS[name].Settings())


@mark.parametrize(
    ("key", "value", "allowed"),
    [
        ("address", 0, "1 to 247"),
        ("address", 248, "1 to 247"),
        ("baud", 300, "1200 to 921600"),
        ("stop_bits", 3, "1 to 2"),
        ("ping_ms", 1.0, "5.0 to 2000.0"),
        ("reply_ms", 1.0, "10.0 to 2000.0"),
        ("unit_mm", 0.0, "0.1 to 100.0"),
        ("no_echo", (-1,), "0 to 65535"),
    ],
)
def test_impossible_settings_are_refused_by_name(key: str, value: object, allowed: str) -> None:
    with raises(ValueError, match=f"{key} is .*: expected {allowed}"):
        Urm13.Settings(**{key: value})


def test_its_port_is_opened_as_the_settings_say() -> None:
    chosen = Urm14.Settings(baud=38_400, parity="even", stop_bits=2)
    options = {"baud": 38_400, "parity": "even", "stop_bits": 2}
    assert Urm14(role(1.0), chosen).port_options == options


def test_another_model_at_the_address_is_named() -> None:
    line, _ = bench(slave=urm(product=5))
    line.run(300 * MS)
    health = line.line.devices[0].health(line.now_ns)
    assert (health.state, health.level) == (State.WRONG_DEVICE, Level.ERROR)
    assert health.message == "Modbus address 12 (0x0c) is URM15, not URM14: check its address and `driver`"
    assert line.readings == []


def test_a_product_that_nobody_knows_is_told_by_its_number() -> None:
    line, _ = bench(slave=urm(product=0x1234))
    line.run(300 * MS)
    assert "is product 0x1234, not URM14" in line.line.devices[0].health(0).message


def test_silence_is_a_missing_device_asked_for_ever_less_often() -> None:
    line, _ = bench(slave=urm(address=0x20))
    line.run(10_000 * MS)
    health = line.line.devices[0].health(line.now_ns)
    assert health.state is State.MISSING
    assert "no reply from Modbus address 12 (0x0c): check its power, wires and address" in health.message
    assert 4 <= health.counts["missing"] <= 10


def test_a_refusal_is_a_fault_with_its_name() -> None:
    line, slave = bench()
    del slave.registers[1]
    line.run(300 * MS)
    health = line.line.devices[0].health(line.now_ns)
    assert health.state is State.FAULTY
    assert health.message == "Modbus address 12 (0x0c) refuses: illegal address (Modbus exception 2)"


def test_a_refusal_to_ping_gives_no_reading_but_a_fault() -> None:
    line, slave = bench()
    line.run(50 * MS)
    slave.spoilt = lambda frame: sealed(0x0C, 0x86, 4) if frame[1] == 6 else b""
    line.run(40 * MS)
    health = line.line.devices[0].health(line.now_ns)
    assert health.state is State.FAULTY
    assert health.message.endswith("did not take the command to fire: device failure (Modbus exception 4)")
    assert line.readings == []


@mark.parametrize(
    "says", ["0C 03 08 00 00 00 00 00 00 00 00 00 00", "0D 03 08 30 39 00 D7 00 00 00 04 00 00", "FF"]
)
def test_a_lasting_wrong_reply_is_garbled_and_counted(says: str) -> None:
    line, slave = bench()
    line.run(70 * MS)
    slave.spoilt = lambda frame: bytes.fromhex(says)
    line.run(2000 * MS)
    (reading,) = line.readings
    assert reading.outcome is Outcome.INVALID
    health = line.line.devices[0].health(line.now_ns)
    assert health.state is State.GARBLED
    assert "noise, two devices at one address, or not 19200 baud" in health.message
    assert health.counts["garbled"] >= 3


def test_one_wrong_reply_costs_one_reading() -> None:
    line, slave = bench()
    slave.registers[5] = 12_345
    line.run(70 * MS)
    slave.spoilt = lambda frame: frame[:-1] + bytes((frame[-1] ^ 1,))
    line.run(120 * MS)
    slave.spoilt = lambda frame: frame
    line.run(400 * MS)
    assert [reading.outcome for reading in line.readings] == [Outcome.INVALID, Outcome.ECHO]
    assert "wrong checksum" in line.readings[0].reason


def test_a_device_that_forgot_its_set_up_is_set_up_again() -> None:
    line, slave = bench()
    slave.registers[5] = 12_345
    line.run(100 * MS)
    slave.registers[8] = 0
    line.run(600 * MS)
    assert [reading.outcome for reading in line.readings] == [Outcome.INVALID, Outcome.ECHO]
    assert line.readings[0].reason == ("control register 0x0000 is not what was set up: was it restarted?")
    assert slave.written == [(8, 0x0C), (8, 0x04), (8, 0x0C)]


def test_while_the_trigger_bit_stands_it_is_waited_for_if_the_device_clears_it() -> None:
    line, slave = bench(clears_trigger=True)
    slave.registers[5] = 11_111
    line.run(200 * MS)
    assert line.readings == []
    slave.registers |= {5: 12_345, 8: 4}
    line.run(50 * MS)
    assert [reading.distance for reading in line.readings] == [approx(1.2345)]
    assert line.line.devices[0].health(0).counts["busy"] >= 1


def test_a_trigger_bit_that_never_falls_is_told_with_the_key_that_says_so() -> None:
    line, _ = bench(clears_trigger=True)
    line.run(1000 * MS)
    assert [reading.reason for reading in line.readings] == ["not ready in time"]
    health = line.line.devices[0].health(line.now_ns)
    assert health.state is State.FAULTY
    assert health.message.endswith("does not end its ping: is `clears_trigger` right?")


def test_a_busy_device_is_asked_again() -> None:
    line, slave = bench()
    slave.registers[5] = 12_345
    line.run(150 * MS)
    slave.spoilt = lambda frame: sealed(0x0C, 0x83, 6)
    line.run(60 * MS)
    slave.spoilt = lambda frame: frame
    line.run(40 * MS)
    assert [reading.outcome for reading in line.readings] == [Outcome.ECHO]


def test_a_reply_that_comes_too_late_is_not_taken_for_the_next() -> None:
    line, slave = bench()
    slave.registers[5] = 12_345
    line.run(150 * MS)
    line.late_ns = 200 * MS
    line.run(2000 * MS)
    assert {reading.outcome for reading in line.readings} == {Outcome.INVALID}
    line.late_ns = 0
    line.run(3000 * MS)
    assert line.readings[-1].outcome is Outcome.ECHO
    assert line.line.devices[0].health(line.now_ns).state is State.WELL


def test_one_that_repeats_the_trigger_when_it_has_measured_is_given_the_time_for_it() -> None:
    line, slave = bench(reply_ms=300.0, ping_ms=5.0)
    slave.registers[5] = 12_345
    line.late_ns = 200 * MS
    line.run(1500 * MS)
    assert [reading.outcome for reading in line.readings] == [Outcome.ECHO] * len(line.readings)
    assert line.readings[0].stamp_error_ns > 100 * MS


def test_an_adapter_that_echoes_is_told_so() -> None:
    slave = urm(distance=12_345)
    line = Bench([Urm14(role(1.5), Urm14.Settings(echo=True))], [slave], echo=True)
    line.run(300 * MS)
    assert [reading.distance for reading in line.readings] == [approx(1.2345)]


@mark.parametrize(
    ("says", "does", "message"),
    [
        (False, True, "the adapter echoes: set `echo = true`"),
        (True, False, "does not echo: set `echo = false`"),
    ],
)
def test_an_adapter_that_does_otherwise_is_told_with_the_mend(says: bool, does: bool, message: str) -> None:
    line = Bench([Urm14(role(1.5), Urm14.Settings(echo=says))], [urm()], echo=does)
    line.run(2000 * MS)
    health = line.line.devices[0].health(line.now_ns)
    assert health.state is State.GARBLED
    assert message in health.message


def two(period_ns: int) -> tuple[Bench, list[Slave]]:
    """A URM14 and a URM15 on one line, both due at the same time."""
    slaves = [urm(distance=12_345), urm(0x0F, 5, 1111)]
    turns = [replace(role(1.5, name), slot=Slot(period_ns, 0)) for name in ("a", "b")]
    return Bench([Urm14(turns[0], Urm14.Settings()), Urm15(turns[1], Urm15.Settings())], slaves), slaves


def test_two_on_a_line_are_talked_to_one_after_the_other() -> None:
    line, _ = two(400 * MS)
    line.run(2000 * MS)
    told = {(reading.sensor, round(reading.distance, 4)) for reading in line.readings}
    assert told == {("a", 1.2345), ("b", 1.111)}


@given(integers(150, 500))
@settings(max_examples=20)
def test_between_frames_the_line_is_silent_for_3_5_characters(period_ms: int) -> None:
    line, _ = two(period_ms * MS)
    line.run(1500 * MS)
    assert len(line.came) > 10
    for (came_ns, _), (sent_ns, _) in zip(line.came, line.sent[1:], strict=False):
        assert sent_ns - came_ns >= quiet_ns(19_200)


def test_a_port_lost_in_a_ping_is_an_invalid_reading_and_a_new_set_up() -> None:
    line, slave = bench()
    slave.registers[5] = 12_345
    line.run(100 * MS)
    line.line.lost(line.now_ns)
    line.run(500 * MS)
    assert [reading.reason for reading in line.readings] == ["port lost", ""]
    assert line.line.devices[0].health(line.now_ns).counts["set-ups"] == 2


def test_a_new_address_is_written_to_its_register_and_its_repetition_awaited() -> None:
    transfer = address_change(0x0C, 0x21)
    assert transfer.send == (sealed(*bytes.fromhex("0C 06 00 02 00 21")),)
    assert transfer.reply_length is not None
    assert transfer.reply_length(bytes.fromhex("0C 86 03")) == 8


@mark.parametrize("address", [0, 248])
def test_an_impossible_address_is_refused(address: int) -> None:
    with raises(ValueError, match=f"address is {address}: expected 1 to 247"):
        address_change(0x0C, address)


def test_a_general_call_is_refused() -> None:
    with raises(ValueError, match="obeys no general call"):
        Urm14(replace(role(1.0), call=Call.ALL), Urm14.Settings())


def mutated(at: int, bit: int) -> Callable[[bytes], bytes]:
    def spoil(frame: bytes) -> bytes:
        index = at % len(frame)
        return frame[:index] + bytes((frame[index] ^ 1 << bit,)) + frame[index + 1 :]

    return spoil


WAYS = [lambda frame: frame, lambda frame: frame[:-1], lambda frame: frame + b"\0", lambda frame: b""]


@given(
    lists(
        sampled_from(WAYS)
        | integers(0, 100).flatmap(lambda at: integers(0, 7).map(lambda bit: mutated(at, bit)))
        | binary(min_size=1, max_size=20).map(lambda data: lambda frame: data),
        max_size=12,
    ),
    integers(0, 0xFFFF),
)
@settings(max_examples=60)
def test_whatever_it_says_every_reading_is_possible_and_it_recovers(
    ways: list[Callable[[bytes], bytes]], counts: int
) -> None:
    line, slave = bench()
    slave.registers[5] = counts
    for way in ways:
        slave.spoilt = way
        line.run(137 * MS)
    slave.spoilt = lambda frame: frame
    slave.registers[5] = 12_345
    line.run(4000 * MS)
    assert line.readings[-1].distance == approx(1.2345)
    for reading in line.readings:
        assert (reading.outcome is Outcome.ECHO) == (0.1 <= reading.distance < 1.5)
    assert all(b.stamp_ns > a.stamp_ns for a, b in pairwise(line.readings))
