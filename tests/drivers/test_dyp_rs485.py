from math import isnan

from hypothesis import given, settings
from hypothesis.strategies import binary, integers, lists
from pytest import approx, mark, raises

from echogrid.drivers.device import State
from echogrid.drivers.dyp_rs485 import DypRs485
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole, Slot

from .modbus_bench import BYTE_NS, MS, TURNAROUND_NS, Bench, Slave, sealed

SPEED = 343.0
ROLE = RangerRole("rear", 0.03, 4.5, Slot(1000 * MS, 200 * MS), SPEED)
ANSWERS_NS = 120 * MS
KEYS = {"baud": 19_200}
"""The bench's speed."""


def bench(distance: int = 1953, role: RangerRole = ROLE, **keys: object) -> tuple[Bench, Slave]:
    """A line with a DYP that answers as late as its real-time distance takes."""
    slave = Slave(1, {0x0100: 1111, 0x0101: distance, 0x0102: 215})
    line = Bench([DypRs485(role, DypRs485.Settings(**(KEYS | keys)))], [slave])
    line.late_ns = ANSWERS_NS - TURNAROUND_NS
    return line, slave


@mark.parametrize(
    ("filtered", "request_", "metres"),
    [(False, "01 03 01 01 00 01 D4 36", 1.953), (True, "01 03 01 00 00 01 85 F6", 1.111)],
)
def test_its_distance_is_asked_for_in_its_turn(filtered: bool, request_: str, metres: float) -> None:
    line, _ = bench(filtered=filtered)
    line.run(700 * MS)
    assert line.sent[-1] == (200 * MS, bytes.fromhex(request_))
    assert [reading.distance for reading in line.readings] == [approx(metres)]
    assert line.readings[0].raw[:3] == bytes.fromhex("01 03 02")


def test_before_that_it_is_asked_for_its_temperature_for_which_it_need_not_ping() -> None:
    line, _ = bench()
    line.run(199 * MS)
    assert [frame[:6] for _, frame in line.sent] == [bytes.fromhex("01 03 01 02 00 01")]


def test_the_ping_was_at_some_time_between_request_and_reply() -> None:
    line, _ = bench()
    line.run(700 * MS)
    (reading,) = line.readings
    sent_ns = 200 * MS + 8 * BYTE_NS
    end_ns = 200 * MS + 8 * BYTE_NS + ANSWERS_NS + 7 * BYTE_NS
    fired_ns = reading.stamp_ns - round(1.953 / SPEED * 1e9)
    assert fired_ns == approx((sent_ns + end_ns) / 2, abs=MS // 2)
    assert reading.stamp_error_ns == approx((end_ns - sent_ns) / 2, abs=MS // 2)


@mark.parametrize(
    ("millimetres", "outcome"),
    [
        (0, Outcome.NO_ECHO),
        (0xFFFD, Outcome.NO_ECHO),
        (0xFFFE, Outcome.INVALID),
        (29, Outcome.TOO_CLOSE),
        (30, Outcome.ECHO),
        (4499, Outcome.ECHO),
        (4500, Outcome.NO_ECHO),
    ],
)
def test_every_value_has_its_meaning(millimetres: int, outcome: Outcome) -> None:
    line, _ = bench(millimetres)
    line.run(700 * MS)
    (reading,) = line.readings
    assert reading.outcome is outcome
    assert isnan(reading.distance) == (outcome is not Outcome.ECHO)


def test_a_part_whose_codes_are_others_is_told_so() -> None:
    line, _ = bench(4500, no_echo_mm=(4500,), invalid_mm=(0,))
    line.run(700 * MS)
    assert line.readings[0].outcome is Outcome.NO_ECHO


@mark.parametrize("key", ["no_echo_mm", "invalid_mm"])
def test_impossible_codes_are_refused_by_name(key: str) -> None:
    with raises(ValueError, match=f"{key} is 70000: expected 0 to 65535"):
        DypRs485.Settings(**{key: (70_000,)})


def test_it_is_waited_for_longer_than_it_takes_and_no_longer_than_that() -> None:
    line, _ = bench(filtered=True)
    line.late_ns = 600 * MS
    line.run(2100 * MS)
    assert [reading.outcome for reading in line.readings] == [Outcome.ECHO]
    line.late_ns = 800 * MS
    line.run(3000 * MS)
    assert line.readings[-1].reason == "not ready in time"
    assert line.line.devices[0].health(line.now_ns).state is State.MISSING


def test_a_part_without_a_thermometer_is_there_all_the_same() -> None:
    line, slave = bench()
    del slave.registers[0x0102]
    line.run(700 * MS)
    assert [reading.outcome for reading in line.readings] == [Outcome.ECHO]


def test_a_refusal_is_an_invalid_reading_and_a_fault_with_its_name() -> None:
    line, slave = bench()
    line.run(199 * MS)
    slave.spoilt = lambda frame: sealed(1, 0x83, 6)
    line.run(200 * MS)
    (reading,) = line.readings
    assert (reading.outcome, reading.reason) == (Outcome.INVALID, "device busy (Modbus exception 6)")
    assert line.line.devices[0].health(line.now_ns).state is State.FAULTY


def test_silence_is_a_missing_device() -> None:
    line, _ = bench()
    line.late_ns = 10_000 * MS
    line.run(3000 * MS)
    health = line.line.devices[0].health(line.now_ns)
    assert health.state is State.MISSING
    assert "no reply from Modbus address 1 (0x01)" in health.message


def test_a_lasting_wrong_checksum_is_garbled() -> None:
    line, slave = bench()
    line.run(199 * MS)
    slave.spoilt = lambda frame: frame[:-1] + bytes((frame[-1] ^ 0x55,))
    line.run(1500 * MS)
    assert "wrong checksum" in line.readings[0].reason
    health = line.line.devices[0].health(line.now_ns)
    assert health.state is State.GARBLED
    assert health.counts["garbled"] >= 2


def test_three_slow_ones_on_a_line_wait_for_each_other() -> None:
    slaves = [Slave(address, {0x0100: 1000 + address, 0x0102: 0}) for address in (1, 2, 3)]
    role = RangerRole("rear", 0.03, 4.5, Slot(2000 * MS, 0), SPEED)
    chosen = [DypRs485.Settings(address=address, filtered=True, **KEYS) for address in (1, 2, 3)]
    line = Bench([DypRs485(role, each) for each in chosen], slaves)
    line.late_ns = 520 * MS
    line.run(9000 * MS)
    assert {round(reading.distance, 3) for reading in line.readings} == {1.001, 1.002, 1.003}
    assert {reading.outcome for reading in line.readings} == {Outcome.ECHO}


@given(lists(binary(max_size=12), max_size=8), integers(0, 0xFFFF))
@settings(max_examples=50)
def test_whatever_it_says_every_reading_is_possible_and_it_recovers(
    answers: list[bytes], millimetres: int
) -> None:
    line, slave = bench(millimetres)
    for answer in answers:
        slave.spoilt = lambda frame, answer=answer: answer
        line.run(333 * MS)
    slave.spoilt = lambda frame: frame
    slave.registers[0x0101] = 1953
    line.run(5000 * MS)
    assert line.readings[-1].distance == approx(1.953)
    for reading in line.readings:
        assert (reading.outcome is Outcome.ECHO) == (0.03 <= reading.distance < 4.5)
