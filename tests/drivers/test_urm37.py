from errno import EPROTO, ETIMEDOUT
from random import Random

from hypothesis import given
from hypothesis.strategies import binary, integers, lists, one_of, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.bus import Break
from echogrid.drivers.device import State
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole, Slot
from echogrid.drivers.urm37 import Urm37, frame, word_of
from echogrid.emulation.devices.urm37 import Urm37Options, Urm37Sensor

from .serial_bench import MS, SPEED, Bench, Joined, room

SLOT = Slot(200 * MS, 30 * MS)
ROLE = RangerRole("front", 0.05, 4.0, SLOT, SPEED)
DISTANCE = bytes.fromhex("22000022")
"""The data sheet's own."""
TEMPERATURE = bytes.fromhex("1155AA10")
"""With data that are free."""
WARM = bytes.fromhex("1100C8D9")
GOLDEN = bytes.fromhex("22012C4F")
"""300 cm, as the maker's examples have it."""


def bench(*answers: bytes | int, greeting: bytes | int = WARM, **settings: object) -> Bench:
    """A ranger played by hand: these are its distances, the last of them for ever."""
    said = list(answers)

    def reply(send: tuple[bytes | Break, ...], now_ns: int) -> bytes | int:
        if send == (TEMPERATURE,):
            return greeting
        assert send == (DISTANCE,)
        return said.pop(0) if len(said) > 1 else said[0]

    return Bench(Urm37(ROLE, Urm37.Settings(**settings)), reply)  # type: ignore[arg-type]


def test_the_data_sheet_s_frames() -> None:
    assert (frame(0x22), frame(0x22, 300)) == (DISTANCE, GOLDEN)
    assert frame(0x11) == bytes.fromhex("11000011")
    assert word_of(0x22, GOLDEN) == 300
    assert word_of(0x22, b"\x00\x17" + GOLDEN) == 300


@given(integers(0, 0xFFFF), integers(0, 3), integers(1, 255))
def test_a_changed_byte_is_no_frame_and_every_word_comes_back(word: int, place: int, change: int) -> None:
    spoilt = bytearray(frame(0x22, word))
    assert word_of(0x22, bytes(spoilt)) == word
    spoilt[place] ^= change
    assert word_of(0x22, bytes(spoilt)) is None


@given(binary(max_size=3))
def test_less_than_a_frame_is_none(data: bytes) -> None:
    assert word_of(0x22, data) is None


def test_it_is_looked_for_by_its_temperature_and_pings_when_its_distance_is_asked_for() -> None:
    play = bench(GOLDEN)
    play.run(60 * MS)
    assert play.sent() == [TEMPERATURE, DISTANCE]
    (reading,) = play.ranged()
    assert (reading.outcome, reading.distance, reading.raw) == (Outcome.ECHO, approx(3.0), GOLDEN)
    assert reading.stamp_ns == 31 * MS + round(3.0 / SPEED * 1e9)


@mark.parametrize(
    ("word", "outcome"),
    [
        (0xFFFF, Outcome.NO_ECHO),
        (450, Outcome.NO_ECHO),
        (4, Outcome.TOO_CLOSE),
        (0, Outcome.TOO_CLOSE),
        (1001, Outcome.INVALID),
    ],
)
def test_every_distance_has_its_meaning(word: int, outcome: Outcome) -> None:
    play = bench(frame(0x22, word))
    play.run(60 * MS)
    assert [reading.outcome for reading in play.ranged()] == [outcome]


def test_unit_and_the_word_for_nothing_can_be_set() -> None:
    play = bench(frame(0x22, 1234), unit_mm=1.0)
    play.run(60 * MS)
    assert [reading.distance for reading in play.ranged()] == [approx(1.234)]
    play = bench(frame(0x22, 0), no_echo=(0,))
    play.run(60 * MS)
    assert [reading.outcome for reading in play.ranged()] == [Outcome.NO_ECHO]


def test_a_garbled_distance_is_invalid_and_says_what_to_look_for() -> None:
    play = bench(EPROTO)
    play.reply = lambda send, now_ns: WARM if send == (TEMPERATURE,) else b"\x22\x01\x2c\x00"
    play.run(32 * MS)
    (reading,) = play.ranged()
    assert (reading.outcome, "jumper set to RS232" in reading.reason) == (Outcome.INVALID, True)


@mark.parametrize(("greeting", "state"), [(ETIMEDOUT, State.MISSING), (EPROTO, State.GARBLED)])
def test_one_that_does_not_greet_is_missing_or_garbled(greeting: int, state: State) -> None:
    play = bench(GOLDEN, greeting=greeting)
    play.run(100 * MS)
    assert (play.state, play.ranged()) == (state, [])


def test_its_own_request_heard_back_is_no_greeting_but_freezing_air_is() -> None:
    play = bench(GOLDEN, greeting=TEMPERATURE)
    play.run(100 * MS)
    assert (play.state, "join no RX to TX" in play.message) == (State.GARBLED, True)
    play = bench(GOLDEN, greeting=bytes.fromhex("11000011"))
    play.run(100 * MS)
    assert play.state is State.WELL


def test_silence_is_no_reading_and_it_is_looked_for_again() -> None:
    play = bench(ETIMEDOUT, GOLDEN)
    play.run(36 * MS)
    assert (play.ranged(), play.sent()) == ([], [TEMPERATURE, DISTANCE, TEMPERATURE])
    play.run(200 * MS)
    assert play.state is State.WELL


@mark.parametrize("wrong", [{"unit_mm": 0.0}, {"no_echo": (70_000,)}])
def test_impossible_settings_are_refused_by_name(wrong: dict[str, object]) -> None:
    with raises(ValueError, match=f"{next(iter(wrong))} is .*: expected"):
        Urm37.Settings(**wrong)  # type: ignore[arg-type]


def test_a_reach_beyond_its_own_is_refused() -> None:
    with raises(ValueError, match=r"max_m is 9.0: expected 0.0 to 8.0"):
        Urm37(RangerRole("front", 0.05, 9.0, SLOT, SPEED), Urm37.Settings())


@given(lists(one_of(binary(min_size=1, max_size=6), sampled_from([GOLDEN, ETIMEDOUT, EPROTO])), max_size=12))
def test_whatever_it_says_echoes_are_possible_and_it_recovers(answers: list[bytes | int]) -> None:
    play = bench(*answers, GOLDEN)
    play.run(4_000 * MS)
    for reading in play.ranged():
        assert (reading.outcome is Outcome.ECHO) == (0.05 <= reading.distance < 4.0)
    play.run(10_000 * MS)
    assert play.state is State.WELL


# The same with the emulated ranger, on the clock that jumps.


def joined(*distances: float, **options: float) -> tuple[Joined, Urm37Sensor]:
    sensor = Urm37Sensor("0", room(*distances), Random(1), Urm37Options(**options))  # type: ignore[arg-type]
    return Joined([sensor], [Urm37(ROLE, Urm37.Settings())]), sensor


@mark.parametrize("distance", [0.1, 1.0, 2.344, 3.9])
def test_it_sees_the_scene_to_half_a_centimetre(distance: float) -> None:
    line, _ = joined(distance)
    readings = line.run(2_000 * MS)
    assert len(readings) >= 9
    assert [reading.distance for reading in readings] == approx([distance] * len(readings), abs=0.0051)


def test_nothing_there_is_no_echo() -> None:
    line, _ = joined()
    assert {reading.outcome for reading in line.run(1_000 * MS)} == {Outcome.NO_ECHO}


@mark.parametrize(
    ("verb", "state"),
    [
        ("off", State.MISSING),
        ("garbage", State.GARBLED),
        ("slow", State.WELL),
        ("delayed", State.WELL),
        ("stuck", State.WELL),
        ("wrong", State.WELL),
    ],
)
def test_each_fault_has_its_state_and_its_end(verb: str, state: State) -> None:
    line, sensor = joined(1.0)
    line.run(1_000 * MS)
    sensor.fault(verb, line.clock.now_ns())
    line.run(3_000 * MS)
    readings = line.run(2_000 * MS)
    assert line.states() == [state]
    expected = 1.5 if verb == "wrong" else 1.0
    assert {round(reading.distance, 3) for reading in readings} <= {expected}
    sensor.clear(line.clock.now_ns())
    line.run(3_000 * MS)
    assert {round(reading.distance, 3) for reading in line.run(1_000 * MS)} == {1.0}
    assert line.states() == [State.WELL]


def test_a_late_reply_is_that_of_its_own_ping() -> None:
    line, sensor = joined(1.0)
    sensor.fault("delayed", line.clock.now_ns())
    stamps = [reading.stamp_ns for reading in line.run(3_000 * MS)]
    assert len(stamps) >= 5
    assert all((stamp_ns - round(1e9 / SPEED)) % (200 * MS) < 40 * MS for stamp_ns in stamps)


def test_pulling_its_plug_loses_the_port_until_it_is_back() -> None:
    line, sensor = joined(1.0)
    line.run(1_000 * MS)
    sensor.fault("unplug", line.clock.now_ns(), 500 * MS)
    line.run(300 * MS)
    assert line.pump.trouble
    line.run(3_000 * MS)
    assert (line.states(), line.pump.losses) == ([State.WELL], 1)
