from errno import ENXIO, EREMOTEIO
from itertools import pairwise
from math import isnan

from hypothesis import given
from hypothesis.strategies import binary, integers, lists, one_of, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.bus import I2cMessage
from echogrid.drivers.device import State
from echogrid.drivers.i2cxl import FIRE, OWN_SPEED, PATIENCE_NS, REFUSED, I2cxl, address_change, centimetres
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import Slot

from .i2c_bench import MS, SPEED, TRANSFER_NS
from .mute_bench import MuteBench, role

ROLE = role(0.25, 5.0)
PART_INFO = b"\x01\x0a"


def bench(settings: I2cxl.Settings | None = None, answer: bytes = b"\x01\x2c") -> MuteBench:
    return MuteBench(I2cxl(ROLE, settings or I2cxl.Settings()), answer, FIRE)


def after_a_ping(value: int, settings: I2cxl.Settings | None = None) -> MuteBench:
    each = bench(settings, value.to_bytes(2, "big", signed=True))
    each.run(150 * MS)
    return each


def test_two_bytes_are_centimetres_high_byte_first() -> None:
    assert centimetres(bytes.fromhex("01 2C")) == 300
    assert centimetres(bytes.fromhex("02 FD")) == 765
    assert centimetres(bytes.fromhex("FF FF")) == -1


def test_a_ping_is_the_byte_51_and_its_answer_is_read_without_a_register() -> None:
    each = bench(I2cxl.Settings(address=0x71))
    each.run(150 * MS)
    look, ping, answer = (transfer.messages for transfer in each.transfers)
    assert look == answer == (I2cMessage(0x71, read=2),)
    assert ping == (I2cMessage(0x71, write=b"\x51"),)


def test_part_information_at_power_up_is_no_reading() -> None:
    each = bench(answer=PART_INFO)
    each.run(29 * MS)
    assert each.transfers
    assert each.readings == []


def test_it_fires_in_its_slot_and_reads_80_ms_later() -> None:
    each = bench()
    each.run(109 * MS)
    assert (each.fired_ns, each.readings) == ([30 * MS], [])
    each.run(5 * MS)
    assert [reading.outcome for reading in each.ranged()] == [Outcome.ECHO]


@given(integers(1, 400), integers(0, 400))
def test_it_never_fires_again_within_98_ms(period_ms: int, offset_ms: int) -> None:
    device = I2cxl(role(0.25, 5.0, Slot(period_ms * MS, offset_ms * MS)), I2cxl.Settings())
    each = MuteBench(device, b"\x01\x2c", FIRE)
    each.run(1500 * MS)
    assert all(b - a >= 98 * MS for a, b in pairwise(each.fired_ns))


@mark.parametrize(
    ("value", "outcome", "own_metres"),
    [
        (300, Outcome.ECHO, 3.0),
        (20, Outcome.TOO_CLOSE, 0.2),
        (24, Outcome.TOO_CLOSE, 0.24),
        (600, Outcome.NO_ECHO, 5.1),
        (765, Outcome.NO_ECHO, 5.1),
        (0, Outcome.INVALID, 5.1),
        (-1, Outcome.INVALID, 5.1),
        (766, Outcome.INVALID, 5.1),
    ],
)
def test_every_result_has_its_meaning_and_its_moment(value: int, outcome: Outcome, own_metres: float) -> None:
    (reading,) = after_a_ping(value).ranged()
    reached = min(own_metres * SPEED / OWN_SPEED, ROLE.farthest)
    assert reading.outcome is outcome
    assert reading.distance == approx(reached) if outcome is Outcome.ECHO else isnan(reading.distance)
    assert reading.stamp_ns == approx(30 * MS + TRANSFER_NS // 2 + reached / SPEED * 1e9, abs=1)
    assert bool(reading.reason) == (outcome is Outcome.INVALID)


def test_the_minimum_of_the_part_means_as_near_as_that_or_nearer() -> None:
    far_sighted = I2cxl.Settings(minimum_cm=30)
    assert after_a_ping(30, far_sighted).ranged()[0].outcome is Outcome.TOO_CLOSE
    assert after_a_ping(31, far_sighted).ranged()[0].outcome is Outcome.ECHO


def test_another_value_for_nothing_can_be_set() -> None:
    settings = I2cxl.Settings(no_echo_cm=0)
    assert after_a_ping(0, settings).ranged()[0].outcome is Outcome.NO_ECHO


def test_a_part_that_measures_the_temperature_is_believed_to_the_centimetre() -> None:
    (reading,) = after_a_ping(300, I2cxl.Settings(speed_of_sound_m_s=0)).ranged()
    assert reading.distance == 3.0


def test_an_error_value_is_faulty_until_there_is_a_range_again() -> None:
    each = after_a_ping(-2)
    health = each.device.health(each.now_ns)
    assert (health.state, health.message) == (
        State.FAULTY,
        "invalid reading: it says ff fe, which is no range (1 to 765 cm)",
    )
    each.registers = b"\x00\xc8"
    each.run(300 * MS)
    assert each.device.health(each.now_ns).state is State.WELL


@mark.parametrize("errno", [ENXIO, EREMOTEIO])
def test_a_missing_acknowledge_while_it_ranges_means_busy(errno: int) -> None:
    each = bench()
    each.run(100 * MS)
    each.errno = errno
    each.run(20 * MS)
    each.errno = 0
    each.run(20 * MS)
    assert [reading.outcome for reading in each.ranged()] == [Outcome.ECHO]
    assert each.device.health(each.now_ns).counts["busy"] >= 1


def test_the_wait_for_it_is_bounded_and_it_is_looked_for_anew() -> None:
    each = bench()
    each.mute_ns = 10_000 * MS
    each.run(30 * MS + 80 * MS + PATIENCE_NS + MS)
    (reading,) = each.ranged()
    assert (reading.outcome, reading.reason) == (Outcome.INVALID, "not ready in time")
    assert each.device.health(each.now_ns).state is State.MISSING
    each.mute_ns = 0
    each.run(500 * MS)
    assert each.device.health(each.now_ns).state is State.WELL


def test_a_missing_part_is_named_with_its_address() -> None:
    each = bench()
    each.errno = ENXIO
    each.run(1000 * MS)
    health = each.device.health(each.now_ns)
    assert health.state is State.MISSING
    assert "0x70 (7 bit)" in health.message
    assert each.fired_ns == []


def test_the_address_change_is_one_message_behind_two_keys() -> None:
    assert address_change(0x71) == bytes.fromhex("AA A5 E2")


@given(integers(-300, 300))
def test_only_addresses_that_it_takes_can_be_asked_for(address: int) -> None:
    possible = 0x08 <= address <= 0x77 and 2 * address not in REFUSED
    if possible:
        assert address_change(address)[2] >> 1 == address
    else:
        with raises(ValueError, match="address"):
            address_change(address)


@mark.parametrize(
    ("key", "value", "allowed"),
    [
        ("address", 0x80, "0x08 to 0x7f"),
        ("minimum_cm", 0, "1 to 100"),
        ("no_echo_cm", -1, "0 to 32767"),
        ("speed_of_sound_m_s", 34.0, "300.0 to 400.0"),
    ],
)
def test_impossible_settings_are_refused_by_name(key: str, value: float, allowed: str) -> None:
    with raises(ValueError, match=f"{key} is .*: expected {allowed}"):
        I2cxl.Settings(**{key: value})


def test_a_reach_beyond_the_parts_is_refused() -> None:
    with raises(ValueError, match=r"max_m is 8.0: expected 0.0 to 7.65"):
        I2cxl(role(0.25, 8.0), I2cxl.Settings())


@given(lists(one_of(binary(min_size=2, max_size=2), sampled_from([b"\x00\x14", b"\x02\xfd", b"\x01\x2c"]))))
def test_whatever_it_says_each_ping_gives_one_possible_reading(answers: list[bytes]) -> None:
    each = bench()
    for answer in answers:
        each.registers = answer
        each.run(300 * MS)
    assert len(each.readings) == len(each.fired_ns) == len(answers)
    for reading in each.ranged():
        assert (reading.outcome is Outcome.ECHO) == (ROLE.nearest <= reading.distance < ROLE.farthest)


@given(lists(binary(min_size=2, max_size=2), max_size=5))
def test_noise_costs_its_own_readings_only(noise: list[bytes]) -> None:
    each = bench()
    for answer in noise:
        each.registers = answer
        each.run(300 * MS)
    each.registers = b"\x01\x2c"
    each.run(300 * MS)
    assert each.ranged()[-1].distance == approx(3.0 * SPEED / OWN_SPEED)
