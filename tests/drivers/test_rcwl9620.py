from itertools import pairwise
from math import isnan

from hypothesis import given
from hypothesis.strategies import binary, integers, lists, one_of, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.bus import I2cMessage
from echogrid.drivers.device import State
from echogrid.drivers.rcwl9620 import FIRE, PATIENCE_NS, Rcwl9620, micrometres
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import Slot

from .i2c_bench import MS, SPEED, TRANSFER_NS
from .mute_bench import MuteBench, role

ROLE = role(0.05, 4.0)


def bench(settings: Rcwl9620.Settings | None = None, value: int = 1_234_567) -> MuteBench:
    return MuteBench(Rcwl9620(ROLE, settings or Rcwl9620.Settings()), value.to_bytes(3, "big"), FIRE)


def after_a_ping(value: int, settings: Rcwl9620.Settings | None = None) -> MuteBench:
    each = bench(settings, value)
    each.run(200 * MS)
    return each


def test_three_bytes_are_micrometres_high_byte_first() -> None:
    assert micrometres(bytes.fromhex("12 D6 87")) == 1_234_567
    assert micrometres(bytes.fromhex("44 AA 20")) == 4_500_000


def test_a_ping_is_the_byte_01_and_its_answer_is_read_without_a_register() -> None:
    each = bench()
    each.run(200 * MS)
    look, ping, answer = (transfer.messages for transfer in each.transfers)
    assert look == answer == (I2cMessage(0x57, read=3),)
    assert ping == (I2cMessage(0x57, write=b"\x01"),)


def test_it_reads_120_ms_after_it_fired_and_not_before() -> None:
    each = bench()
    each.run(149 * MS)
    assert (each.fired_ns, each.readings) == ([30 * MS], [])
    each.run(5 * MS)
    assert [reading.distance for reading in each.ranged()] == [approx(1.234567)]


@given(integers(1, 400), integers(0, 400))
def test_it_never_fires_again_within_148_ms(period_ms: int, offset_ms: int) -> None:
    device = Rcwl9620(role(0.05, 4.0, Slot(period_ms * MS, offset_ms * MS)), Rcwl9620.Settings())
    each = MuteBench(device, b"\x12\xd6\x87", FIRE)
    each.run(1500 * MS)
    assert all(b - a >= 148 * MS for a, b in pairwise(each.fired_ns))


@mark.parametrize(
    ("value", "outcome", "reached"),
    [
        (2_000_000, Outcome.ECHO, 2.0),
        (40_000, Outcome.TOO_CLOSE, 0.04),
        (4_200_000, Outcome.NO_ECHO, 4.0),
        (4_500_000, Outcome.NO_ECHO, 4.0),
        (5_000_000, Outcome.NO_ECHO, 4.0),
        (5_000_001, Outcome.INVALID, 4.0),
        (0xFFFFFF, Outcome.INVALID, 4.0),
        (0, Outcome.INVALID, 4.0),
    ],
)
def test_every_result_has_its_meaning_and_its_moment(value: int, outcome: Outcome, reached: float) -> None:
    (reading,) = after_a_ping(value).ranged()
    assert reading.outcome is outcome
    assert reading.distance == approx(reached) if outcome is Outcome.ECHO else isnan(reading.distance)
    assert reading.stamp_ns == approx(30 * MS + TRANSFER_NS // 2 + reached / SPEED * 1e9, abs=1)
    assert bool(reading.reason) == (outcome is Outcome.INVALID)


def test_its_own_speed_of_sound_is_replaced_by_that_of_the_air() -> None:
    (reading,) = after_a_ping(2_000_000, Rcwl9620.Settings(speed_of_sound_m_s=340.0)).ranged()
    assert reading.distance == approx(2.0 * SPEED / 340.0)


def test_nearer_than_two_centimetres_is_too_close_whatever_the_role_says() -> None:
    device = Rcwl9620(role(0.0, 4.0), Rcwl9620.Settings())
    each = MuteBench(device, (19_999).to_bytes(3, "big"), FIRE)
    each.run(200 * MS)
    assert each.ranged()[0].outcome is Outcome.TOO_CLOSE


def test_an_impossible_range_is_faulty_until_there_is_a_possible_one() -> None:
    each = after_a_ping(0)
    health = each.device.health(each.now_ns)
    assert (health.state, health.message) == (
        State.FAULTY,
        "invalid reading: 0 um is no range (1 to 5000000)",
    )
    each.registers = b"\x12\xd6\x87"
    each.run(300 * MS)
    assert each.device.health(each.now_ns).state is State.WELL


def test_one_that_does_not_acknowledge_while_it_ranges_is_waited_for() -> None:
    each = bench()
    each.mute_ns = 145 * MS
    each.run(200 * MS)
    assert [reading.outcome for reading in each.ranged()] == [Outcome.ECHO]


def test_the_wait_for_it_is_bounded_and_it_is_looked_for_anew() -> None:
    each = bench()
    each.mute_ns = 10_000 * MS
    each.run(30 * MS + 120 * MS + PATIENCE_NS + MS)
    (reading,) = each.ranged()
    assert (reading.outcome, reading.reason) == (Outcome.INVALID, "not ready in time")
    assert each.device.health(each.now_ns).state is State.MISSING
    each.mute_ns = 0
    each.run(600 * MS)
    assert each.device.health(each.now_ns).state is State.WELL


@mark.parametrize(
    ("key", "value", "allowed"),
    [("address", 0x78, "0x08 to 0x77"), ("speed_of_sound_m_s", 0.0, "300.0 to 400.0")],
)
def test_impossible_settings_are_refused_by_name(key: str, value: float, allowed: str) -> None:
    with raises(ValueError, match=f"{key} is .*: expected {allowed}"):
        Rcwl9620.Settings(**{key: value})


def test_a_reach_beyond_the_parts_is_refused() -> None:
    with raises(ValueError, match=r"max_m is 5.0: expected 0.0 to 4.5"):
        Rcwl9620(role(0.05, 5.0), Rcwl9620.Settings())


@given(lists(one_of(binary(min_size=3, max_size=3), sampled_from([b"\x44\xaa\x20", b"\x12\xd6\x87"]))))
def test_whatever_it_says_each_ping_gives_one_possible_reading(answers: list[bytes]) -> None:
    each = bench()
    for answer in answers:
        each.registers = answer
        each.run(300 * MS)
    assert len(each.readings) == len(each.fired_ns) == len(answers)
    for reading in each.ranged():
        assert (reading.outcome is Outcome.ECHO) == (ROLE.nearest <= reading.distance < ROLE.farthest)
