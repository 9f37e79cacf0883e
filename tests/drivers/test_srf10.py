from itertools import pairwise
from random import Random

from hypothesis import given, settings
from hypothesis.strategies import binary, floats, lists, one_of, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.device import State
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole, Slot
from echogrid.drivers.srf10 import Srf10
from echogrid.emulation.devices.i2c_chip import I2cChip
from echogrid.emulation.devices.srf02 import Srf02Chip
from echogrid.emulation.devices.srf08 import Srf08Chip
from echogrid.emulation.devices.srf10 import Srf10Chip
from echogrid.emulation.devices.surroundings import Surroundings

from .i2c_bench import BUSY, MS, SPEED, TRANSFER_NS, Bench, Joined, room

ROLE = RangerRole("left", 0.06, 3.0, Slot(100 * MS, 30 * MS), SPEED)


def registers(flight_us: int) -> bytes:
    return bytes((7, 0x80)) + flight_us.to_bytes(2, "big")


def bench(settings: Srf10.Settings | None = None) -> Bench:
    play = Bench(Srf10(ROLE, settings or Srf10.Settings()), registers(0))
    play.ping_ns = 18 * MS
    return play


def before(chip: I2cChip) -> Joined:
    return Joined([chip], [Srf10(ROLE, Srf10.Settings())])


def test_it_is_set_up_with_gain_and_range_before_it_fires() -> None:
    play = bench(Srf10.Settings(gain=5))
    play.run(60 * MS)
    assert play.written[:5] == [b"\x00", b"\x00", b"\x01\x05", b"\x02\x45", b"\x00\x52"]


@mark.parametrize(
    ("flight_us", "outcome", "reached"),
    [
        (10_000, Outcome.ECHO, 1.715),
        (0, Outcome.NO_ECHO, 3.0),
        (300, Outcome.TOO_CLOSE, 0.05145),
        (17_600, Outcome.NO_ECHO, 3.0),
        (21_000, Outcome.INVALID, 3.0),
    ],
)
def test_each_result_has_its_meaning_and_its_moment(flight_us: int, outcome: Outcome, reached: float) -> None:
    play = bench()
    play.registers = registers(flight_us)
    play.run(80 * MS)
    (reading,) = play.ranged()
    assert reading.outcome is outcome
    assert reading.stamp_ns == 30 * MS + TRANSFER_NS // 2 + round(reached / SPEED * 1e9)
    assert reading.raw == registers(flight_us)


def test_only_one_echo_is_read() -> None:
    play = bench()
    play.registers = registers(5_000) + bytes((0x20, 0x00))
    play.run(80 * MS)
    (reading,) = play.ranged()
    assert (len(reading.raw), reading.later) == (4, ())


@settings(deadline=None)
@given(floats(0.3, 6.0))
def test_it_never_fires_again_within_58_ms(farthest: float) -> None:
    device = Srf10(RangerRole("left", 0.06, farthest, Slot(20 * MS, 0), SPEED), Srf10.Settings())
    play = Bench(device, registers(0))
    play.run(1000 * MS)
    assert play.fired_ns
    assert all(b - a >= 58 * MS for a, b in pairwise(play.fired_ns))


@mark.parametrize(("key", "value", "allowed"), [("address", 0x80, "0x70 to 0x7f"), ("gain", 17, "0 to 16")])
def test_impossible_settings_are_refused_by_name(key: str, value: int, allowed: str) -> None:
    with raises(ValueError, match=f"{key} is .*: expected {allowed}"):
        Srf10.Settings(**{key: value})


@settings(deadline=None)
@given(
    lists(
        one_of(binary(max_size=5), sampled_from([BUSY * 4, registers(0), registers(9_000)])),
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
@given(floats(0.07, 5.9), floats(320, 355))
def test_it_reads_the_emulated_chip_s_wall_within_its_resolution(distance: float, speed: float) -> None:
    chip = Srf10Chip("ten", Surroundings(room(distance).scene, speed), Random(1))
    joined = Joined([chip], [Srf10(RangerRole("ten", 0.06, 6.0, None, speed), Srf10.Settings())])
    readings = joined.run(1000 * MS)
    assert readings
    assert all(reading.distance == approx(distance, abs=0.0002) for reading in readings)


@mark.parametrize("farthest", [1.1, 3.0, 6.0, 8.0])
def test_one_whose_power_was_cut_between_two_pings_is_set_up_again(farthest: float) -> None:
    chip = Srf10Chip("ten", room(1.0), Random(1))
    role = RangerRole("left", 0.06, farthest, Slot(100 * MS, 30 * MS), SPEED)
    joined = Joined([chip], [Srf10(role, Srf10.Settings())])
    joined.run(1000 * MS)
    chip.fault("off", joined.clock.now_ns(), 10 * MS)
    reasons = [reading.reason for reading in joined.run(300 * MS)]
    assert reasons[0].endswith("it lost its settings (was its power cut?)")
    assert reasons[1:] == [""] * len(reasons[1:])
    assert joined.states() == [State.WELL]
    assert joined.count("set-ups") == [2]


def test_an_srf08_at_its_address_is_noticed_by_its_light() -> None:
    joined = before(Srf08Chip("eight", room(1.0), Random(1)))
    assert joined.run(2000 * MS) == []
    assert joined.states() == [State.WRONG_DEVICE]
    assert "register 1 reads 0x00, as no SRF10's does" in joined.messages()[0]


def test_an_srf02_at_its_address_is_noticed_by_its_time() -> None:
    joined = before(Srf02Chip("two", room(1.0), Random(1)))
    readings = joined.run(2000 * MS)
    assert {reading.outcome for reading in readings} == {Outcome.INVALID}
    assert joined.states() == [State.WRONG_DEVICE]
    assert joined.messages()[0].endswith("is it an SRF02?")


def test_a_bad_contact_is_told_in_its_bad_spells_and_gives_no_false_echo() -> None:
    suffered = before(Srf10Chip("ten", room(1.5), Random(1))).suffer("intermittent")
    assert suffered.states[State.MISSING] > 0
    assert suffered.states[State.WELL] > 0
    assert set(suffered.outcomes) <= {Outcome.ECHO, Outcome.INVALID}
