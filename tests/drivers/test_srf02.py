from itertools import pairwise
from math import isnan
from random import Random

from hypothesis import given, settings
from hypothesis.strategies import binary, floats, integers, lists, one_of, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.devantech import words
from echogrid.drivers.device import Level, State
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole, Slot
from echogrid.drivers.srf02 import Srf02
from echogrid.emulation.devices.srf02 import Srf02Chip
from echogrid.emulation.devices.srf08 import Srf08Chip
from echogrid.emulation.devices.srf10 import Srf10Chip
from echogrid.emulation.devices.srf235 import Srf235Chip

from .i2c_bench import BUSY, MS, SPEED, TRANSFER_NS, Bench, Joined, Ranger, room

ROLE = RangerRole("left", 0.1, 5.0, Slot(100 * MS, 30 * MS), SPEED)
MINIMUM_US = 875
"""15 cm."""


def registers(flight_us: int, minimum_us: int = MINIMUM_US) -> bytes:
    return bytes((6, 0x80)) + flight_us.to_bytes(2, "big") + minimum_us.to_bytes(2, "big")


def bench(role: RangerRole = ROLE) -> Bench:
    return Bench(Srf02(role, Srf02.Settings()), registers(0))


def before(chip: Srf02Chip | Srf08Chip | Srf10Chip | Srf235Chip) -> Joined:
    return Joined([chip], [Srf02(ROLE, Srf02.Settings())])


def test_the_registers_of_a_wall_at_three_metres() -> None:
    assert words(bytes.fromhex("01 2C 00 0F")) == (300, 15)


@mark.parametrize(
    ("flight_us", "outcome", "reached"),
    [
        (10_000, Outcome.ECHO, 1.715),
        (0, Outcome.NO_ECHO, 5.0),
        (MINIMUM_US + 1, Outcome.ECHO, 0.150234),
        (MINIMUM_US, Outcome.TOO_CLOSE, 0.1500625),
        (700, Outcome.TOO_CLOSE, 0.12005),
        (40_000, Outcome.NO_ECHO, 5.0),
    ],
)
def test_every_result_has_its_meaning_and_its_moment(
    flight_us: int, outcome: Outcome, reached: float
) -> None:
    play = bench()
    play.registers = registers(flight_us)
    play.run(115 * MS)
    (reading,) = play.ranged()
    assert reading.outcome is outcome
    assert reading.distance == approx(reached) if outcome is Outcome.ECHO else isnan(reading.distance)
    assert reading.stamp_ns == approx(30 * MS + TRANSFER_NS // 2 + reached / SPEED * 1e9, abs=100)
    assert reading.stamp_error_ns == TRANSFER_NS // 2 + 1000
    assert reading.raw == registers(flight_us)


def test_its_own_minimum_counts_if_it_is_farther_than_the_robot_s_and_the_robot_s_if_not() -> None:
    for nearest, outcome in ((0.1, Outcome.ECHO), (0.3, Outcome.TOO_CLOSE)):
        play = bench(RangerRole("left", nearest, 5.0, Slot(100 * MS, 30 * MS), SPEED))
        play.registers = registers(1_600)
        play.run(115 * MS)
        assert play.ranged()[0].outcome is outcome
    play = bench()
    play.registers = registers(1_600, minimum_us=1_633)
    play.run(115 * MS)
    assert play.ranged()[0].outcome is Outcome.TOO_CLOSE


def test_range_and_minimum_are_read_in_one_go() -> None:
    play = bench()
    play.registers = registers(9_000)
    play.run(115 * MS)
    assert play.written == [b"\x00", b"\x00", b"\x00\x52", b"\x00"]
    assert len(play.ranged()[0].raw) == 6


def test_a_turn_that_only_listens_commands_a_ranging_without_the_ping() -> None:
    role = RangerRole("left", 0.1, 5.0, Slot(100 * MS, 0, listens_every=3), SPEED)
    play = bench(role)
    play.registers = registers(9_000)
    play.run(980 * MS)
    assert play.written.count(b"\x00\x58") == 3
    assert play.written.count(b"\x00\x52") == 6
    assert [reading.listened for reading in play.ranged()].count(True) == 3


@settings(deadline=None)
@given(integers(1, 400), integers(0, 400))
def test_it_never_fires_again_within_68_ms(period_ms: int, offset_ms: int) -> None:
    play = bench(RangerRole("left", 0.1, 5.0, Slot(period_ms * MS, offset_ms * MS), SPEED))
    play.ping_ns = 65 * MS
    play.run(1000 * MS)
    assert play.fired_ns
    assert all(b - a >= 68 * MS for a, b in pairwise(play.fired_ns))


@mark.parametrize("register", [0x00, 0x5A, 0x81])
def test_a_chip_with_something_in_the_unused_register_is_another_one(register: int) -> None:
    play = bench()
    play.registers = bytes((6, register, 0, 0, 0, 0))
    play.run(1000 * MS)
    assert play.fired_ns == []
    assert play.state is State.WRONG_DEVICE
    assert f"register 1 reads {register:#04x}, as no SRF02's does" in play.device.health(0).message


@mark.parametrize("minimum_us", [0, 289, 2_901, 0xFFFF])
def test_a_minimum_that_cannot_be_is_not_an_srf02_s(minimum_us: int) -> None:
    play = bench()
    play.registers = registers(9_000, minimum_us)
    play.run(1000 * MS)
    assert {reading.outcome for reading in play.ranged()} == {Outcome.INVALID}
    assert f"a minimum of {minimum_us} us is no SRF02's: is it an SRF10" in play.ranged()[0].reason
    assert play.state is State.WRONG_DEVICE


def test_a_second_device_that_pulls_the_unused_register_down_is_a_conflict() -> None:
    play = bench()
    play.run(200 * MS)
    play.registers = bytes((6, 0)) + registers(9_000)[2:]
    play.run(2000 * MS)
    assert play.state is State.CONFLICT
    play.registers = registers(9_000)
    play.run(2200 * MS)
    assert play.state is State.WELL


def test_one_that_is_busy_for_longer_than_documented_is_faulty() -> None:
    play = bench()
    play.ping_ns = 85 * MS
    play.run(200 * MS)
    assert play.ranged()[0].reason == "busy for 82 ms, not 66: is it failing?"
    assert play.state is State.FAULTY


def test_a_reach_that_it_cannot_time_is_refused() -> None:
    with raises(ValueError, match=r"max_m is 12.0: expected 0.0 to 11.15"):
        Srf02(RangerRole("left", 0.1, 12.0, None, SPEED), Srf02.Settings())


def test_impossible_settings_are_refused_by_name() -> None:
    with raises(ValueError, match="address is 0x6f: expected 0x70 to 0x7f"):
        Srf02.Settings(address=0x6F)


@settings(deadline=None)
@given(
    lists(
        one_of(
            binary(max_size=7),
            sampled_from([BUSY * 6, registers(0), registers(9_000), registers(700)]),
        ),
        max_size=30,
    )
)
def test_whatever_the_chip_says_each_ping_gives_one_possible_reading(answers: list[bytes]) -> None:
    play = bench()
    for answer in answers:
        play.registers = answer
        play.run(100 * MS)
    play.registers = registers(0)
    play.run(95 * MS)
    assert len(play.fired_ns) - len(play.readings) in (0, 1)
    for reading in play.ranged():
        assert (reading.outcome is Outcome.ECHO) == (ROLE.nearest <= reading.distance < ROLE.farthest)


@settings(deadline=None)
@given(floats(0.16, 4.9), floats(320, 355))
def test_it_reads_the_emulated_chip_s_wall_within_its_resolution(distance: float, speed: float) -> None:
    echo = room(distance)
    role = RangerRole("left", 0.1, 5.0, None, speed)
    chip = Srf02Chip("two", type(echo)(echo.scene, speed), Random(1))
    joined = Joined([chip], [Srf02(role, Srf02.Settings())])
    joined.run(1000 * MS)
    readings = joined.run(500 * MS)
    assert readings
    assert all(reading.distance == approx(distance, abs=0.0002) for reading in readings)


def test_after_power_up_a_wall_at_20_cm_shows_when_the_dead_zone_has_shrunk() -> None:
    chip = Srf02Chip("two", room(0.2), Random(1))
    joined = before(chip)
    outcomes = [reading.outcome for reading in joined.run(1000 * MS)]
    first = outcomes.index(Outcome.ECHO)
    assert 3 <= first <= 6
    assert Outcome.ECHO not in outcomes[:first]
    assert set(outcomes[first:]) == {Outcome.ECHO}
    chip.fault("off", joined.clock.now_ns(), 10 * MS)
    assert Outcome.ECHO not in [reading.outcome for reading in joined.run(300 * MS)]


@mark.parametrize(
    "stranger", [Srf08Chip("s", room(1.0), Random(1)), Srf10Chip("s", room(1.0), Random(1))], ids=lambda s: s
)
def test_another_of_the_family_at_its_address_is_noticed(stranger: Srf08Chip | Srf10Chip) -> None:
    joined = before(stranger)
    readings = joined.run(2000 * MS)
    assert {reading.outcome for reading in readings} <= {Outcome.INVALID}
    assert joined.states() == [State.WRONG_DEVICE]


def test_the_chip_s_loss_of_power_needs_no_set_up() -> None:
    chip = Srf02Chip("two", room(1.0), Random(1))
    joined = before(chip)
    joined.run(1000 * MS)
    chip.fault("off", joined.clock.now_ns() + 99 * MS, 5 * MS)
    joined.run(1000 * MS)
    assert joined.states() == [State.WELL]


def test_a_bad_contact_is_told_in_its_bad_spells_and_gives_no_false_echo() -> None:
    suffered = before(Srf02Chip("front", room(1.5), Random(1))).suffer("intermittent")
    assert suffered.states[State.MISSING] > 0
    assert suffered.states[State.WELL] > 0
    assert set(suffered.outcomes) <= {Outcome.ECHO, Outcome.INVALID}


def test_health_is_stale_before_the_set_up() -> None:
    device: Ranger = Srf02(ROLE, Srf02.Settings())
    assert device.health(0).level is Level.STALE
