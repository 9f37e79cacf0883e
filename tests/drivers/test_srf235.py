from itertools import pairwise
from random import Random

from hypothesis import given, settings
from hypothesis.strategies import binary, floats, lists, one_of, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.device import State
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole, Slot
from echogrid.drivers.srf235 import Srf235
from echogrid.emulation.devices.i2c_chip import I2cChip
from echogrid.emulation.devices.srf02 import Srf02Chip
from echogrid.emulation.devices.srf08 import Srf08Chip
from echogrid.emulation.devices.srf10 import Srf10Chip
from echogrid.emulation.devices.srf235 import Srf235Chip, Srf235Options
from echogrid.emulation.devices.surroundings import Surroundings

from .i2c_bench import BUSY, MS, SPEED, TRANSFER_NS, Bench, Joined, room

ROLE = RangerRole("left", 0.1, 1.2, Slot(25 * MS, 5 * MS), SPEED)
MILLIMETRES, MICROSECONDS = Srf235.Settings(unit_mm=1.0), Srf235.Settings(command=0x52)


def registers(count: int) -> bytes:
    return bytes((3, 0x80)) + count.to_bytes(2, "big")


def bench(settings: Srf235.Settings | None = None, role: RangerRole = ROLE) -> Bench:
    settings = settings or Srf235.Settings()
    return Bench(Srf235(role, settings), registers(0), fires=bytes((0, settings.command)))


def before(chip: I2cChip, settings: Srf235.Settings | None = None) -> Joined:
    return Joined([chip], [Srf235(ROLE, settings or Srf235.Settings())])


def test_it_needs_no_settings_and_fires_at_once() -> None:
    play = bench()
    play.run(20 * MS)
    assert play.written[:3] == [b"\x00", b"\x00", b"\x00\x51"]


@mark.parametrize(
    ("settings", "count", "outcome", "distance"),
    [
        (None, 85, Outcome.ECHO, 0.85),
        (None, 8, Outcome.TOO_CLOSE, None),
        (None, 125, Outcome.NO_ECHO, None),
        (None, 0, Outcome.NO_ECHO, None),
        (None, 850, Outcome.INVALID, None),
        (MILLIMETRES, 850, Outcome.ECHO, 0.85),
        (MILLIMETRES, 85, Outcome.TOO_CLOSE, None),
        (MILLIMETRES, 45, Outcome.INVALID, None),
        (MICROSECONDS, 5_000, Outcome.ECHO, 0.8575),
        (MICROSECONDS, 85, Outcome.INVALID, None),
    ],
)
def test_a_count_is_what_its_unit_makes_of_it(
    settings: Srf235.Settings | None, count: int, outcome: Outcome, distance: float | None
) -> None:
    play = bench(settings)
    play.registers = registers(count)
    play.run(20 * MS)
    (reading,) = play.ranged()
    assert reading.outcome is outcome
    if distance is not None:
        assert reading.distance == approx(distance)
        fired_ns = 5 * MS + TRANSFER_NS // 2
        assert reading.stamp_ns == approx(fired_ns + distance / SPEED * 1e9, abs=10)


def test_a_range_that_cannot_be_hints_at_the_unit() -> None:
    play = bench()
    play.registers = registers(850)
    play.run(100 * MS)
    assert play.ranged()[0].reason == "850 units are 8.500 m, which it can't range: check unit_mm and command"
    assert play.state is State.FAULTY
    assert play.device.health(play.now_ns).counts["set-ups"] == 1


def test_in_colder_air_its_centimetres_are_corrected() -> None:
    play = bench(role=RangerRole("left", 0.1, 1.2, Slot(25 * MS, 5 * MS), 325.0))
    play.registers = registers(100)
    play.run(20 * MS)
    assert play.ranged()[0].distance == approx(325.0 / 343.0)


def test_it_pings_fifty_times_a_second_and_more() -> None:
    play = bench(role=RangerRole("left", 0.1, 1.2, Slot(14 * MS, 0), SPEED))
    play.ping_ns = 10 * MS
    play.run(1000 * MS)
    assert len(play.ranged()) >= 70
    assert all(b - a >= 10 * MS for a, b in pairwise(play.fired_ns))


@mark.parametrize(
    ("key", "value", "allowed"),
    [
        ("address", 0x80, "0x70 to 0x7f"),
        ("command", 0x50, "81 to 82"),
        ("unit_mm", 0.5, "1.0 to 10.0"),
    ],
)
def test_impossible_settings_are_refused_by_name(key: str, value: float, allowed: str) -> None:
    with raises(ValueError, match=f"{key} is .*: expected {allowed}"):
        Srf235.Settings(**{key: value})  # type: ignore[arg-type]  # that is what is tried


def test_a_reach_beyond_its_data_sheet_is_refused() -> None:
    with raises(ValueError, match=r"max_m is 1.5: expected 0.0 to 1.2"):
        Srf235(RangerRole("left", 0.1, 1.5, None, SPEED), Srf235.Settings())


@settings(deadline=None)
@given(
    lists(
        one_of(binary(max_size=5), sampled_from([BUSY * 4, registers(0), registers(90)])),
        max_size=30,
    ),
    sampled_from([None, MILLIMETRES, MICROSECONDS]),
)
def test_whatever_the_chip_says_each_ping_gives_one_possible_reading(
    answers: list[bytes], settings: Srf235.Settings | None
) -> None:
    play = bench(settings)
    for answer in answers:
        play.registers = answer
        play.run(30 * MS)
    play.registers = registers(0)
    play.run(100 * MS)
    assert len(play.fired_ns) - len(play.readings) in (0, 1)
    for reading in play.ranged():
        assert (reading.outcome is Outcome.ECHO) == (ROLE.nearest <= reading.distance < ROLE.farthest)


@settings(deadline=None)
@mark.parametrize(
    ("settings", "unit_mm", "resolution"),
    [(None, 10.0, 0.0051), (MILLIMETRES, 1.0, 0.0006), (MICROSECONDS, 10.0, 0.0002)],
)
@given(distance=floats(0.11, 1.19))
def test_it_reads_the_emulated_chip_s_wall_within_its_resolution(
    settings: Srf235.Settings | None, unit_mm: float, resolution: float, distance: float
) -> None:
    chip = Srf235Chip("pencil", room(distance), Random(1), Srf235Options(unit_mm=unit_mm))
    readings = before(chip, settings).run(300 * MS)
    echoes = [reading.distance for reading in readings if reading.outcome is Outcome.ECHO]
    assert echoes == approx([distance] * len(readings), abs=resolution) or distance > 1.2 - resolution


@mark.parametrize("speed", [325.0, 355.0])
def test_microseconds_and_corrected_centimetres_are_right_in_any_air(speed: float) -> None:
    role = RangerRole("left", 0.1, 1.2, None, speed)
    chip = Srf235Chip("pencil", Surroundings(room(1.0).scene, speed), Random(1))
    for chosen in (Srf235.Settings(), MICROSECONDS):
        readings = Joined([chip], [Srf235(role, chosen)]).run(300 * MS)
        assert readings
        assert all(reading.distance == approx(1.0, abs=0.006) for reading in readings)


@mark.parametrize("kind", [Srf02Chip, Srf08Chip, Srf10Chip])
def test_another_of_the_family_at_its_address_is_noticed_by_its_time(
    kind: type[Srf02Chip | Srf08Chip | Srf10Chip],
) -> None:
    joined = before(kind("stranger", room(1.0), Random(1)))
    readings = joined.run(2000 * MS)
    assert {reading.outcome for reading in readings} == {Outcome.INVALID}
    assert joined.states() == [State.WRONG_DEVICE]
    assert joined.messages()[0].endswith("is it an SRF02, SRF08 or SRF10?")


def test_a_bad_contact_is_told_in_its_bad_spells_and_gives_no_false_echo() -> None:
    suffered = before(Srf235Chip("pencil", room(0.6), Random(1))).suffer("intermittent")
    assert suffered.states[State.MISSING] > 0
    assert suffered.states[State.WELL] > 0
    assert set(suffered.outcomes) <= {Outcome.ECHO, Outcome.INVALID}
