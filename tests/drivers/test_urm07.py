from errno import EPROTO, ETIMEDOUT
from random import Random

from hypothesis import given
from hypothesis.strategies import binary, integers, lists, one_of, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.bus import Break
from echogrid.drivers.device import State
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole, Slot
from echogrid.drivers.urm07 import Urm07, address_change, frame, word_of
from echogrid.emulation.devices.urm07 import Urm07Options, Urm07Sensor

from .serial_bench import MS, SPEED, Bench, Joined, room

SLOT = Slot(200 * MS, 30 * MS)
ROLE = RangerRole("front", 0.2, 4.0, SLOT, SPEED)
DISTANCE = bytes.fromhex("55AA11000212")
GOLDEN = bytes.fromhex("55AA11020212345A")
"""The data sheet's own: 0x1234."""
TEMPERATURE = bytes.fromhex("55AA11000313")
WARM = bytes.fromhex("55AA110203 00FF 14".replace(" ", ""))
"""The data sheet's own: 25.5 degC."""


def told(word: int, address: int = 0x11, command: int = 2) -> bytes:
    return frame(address, command, word.to_bytes(2, "big"))


def bench(*answers: bytes | int, greeting: bytes | int = WARM, **settings: object) -> Bench:
    """A ranger played by hand: these are its distances, the last of them for ever."""
    said = list(answers)

    def reply(send: tuple[bytes | Break, ...], now_ns: int) -> bytes | int:
        (request,) = send
        assert isinstance(request, bytes)
        if request[4] == 3:
            return greeting
        if request[4] == 1:
            return b""
        return said.pop(0) if len(said) > 1 else said[0]

    return Bench(Urm07(ROLE, Urm07.Settings(**settings)), reply)  # type: ignore[arg-type]


def test_the_data_sheet_s_frames() -> None:
    assert (frame(0x11, 2), frame(0x11, 3)) == (DISTANCE, TEMPERATURE)
    assert frame(0x11, 2, b"\x12\x34") == GOLDEN
    assert word_of(0x11, 2, GOLDEN) == 0x1234
    assert word_of(0x11, 3, WARM) == 255
    assert frame(0x11, 1)[-1] == 0x11


@given(integers(0, 0xFFFF), integers(0, 7), integers(1, 255))
def test_a_changed_byte_is_no_frame_and_every_word_comes_back(word: int, place: int, change: int) -> None:
    spoilt = bytearray(told(word))
    assert word_of(0x11, 2, bytes(spoilt)) == word
    spoilt[place] ^= change
    assert word_of(0x11, 2, bytes(spoilt)) is None


@given(binary(max_size=7))
def test_less_than_a_frame_is_none(data: bytes) -> None:
    assert word_of(0x11, 2, data) is None


def test_another_one_s_frame_and_one_for_another_command_are_none() -> None:
    assert word_of(0x12, 2, GOLDEN) is None
    assert word_of(0x11, 3, GOLDEN) is None


def test_it_is_looked_for_by_its_temperature_and_pings_when_its_distance_is_asked_for() -> None:
    play = bench(told(300))
    play.run(60 * MS)
    assert play.sent() == [TEMPERATURE, DISTANCE]
    (reading,) = play.ranged()
    assert (reading.outcome, reading.distance, reading.raw) == (Outcome.ECHO, approx(3.0), told(300))
    assert reading.stamp_ns == 31 * MS + round(3.0 / SPEED * 1e9)


@mark.parametrize(("farthest", "wait_ns"), [(3.0, 30 * MS), (5.0, round(10.0 / SPEED * 1e9) + 5 * MS)])
def test_one_that_triggers_is_told_to_ping_and_asked_when_the_sound_is_back(
    farthest: float, wait_ns: int
) -> None:
    play = bench(told(200), triggers=True)
    play.device = Urm07(RangerRole("front", 0.2, farthest, SLOT, SPEED), Urm07.Settings(triggers=True))
    play.run(100 * MS)
    assert play.sent() == [TEMPERATURE, frame(0x11, 1), DISTANCE]
    assert play.asked[2][0] - (play.asked[1][0] + MS) == wait_ns
    assert [reading.distance for reading in play.ranged()] == [approx(2.0)]


@mark.parametrize(
    ("word", "outcome"),
    [
        (0xFFFF, Outcome.NO_ECHO),
        (450, Outcome.NO_ECHO),
        (19, Outcome.TOO_CLOSE),
        (1101, Outcome.INVALID),
    ],
)
def test_every_distance_has_its_meaning(word: int, outcome: Outcome) -> None:
    play = bench(told(word))
    play.run(60 * MS)
    assert [reading.outcome for reading in play.ranged()] == [outcome]


def test_unit_and_the_word_for_nothing_can_be_set() -> None:
    play = bench(GOLDEN, unit_mm=0.5)
    play.run(60 * MS)
    assert [reading.distance for reading in play.ranged()] == [approx(2.33)]
    play = bench(told(0), no_echo=(0,))
    play.run(60 * MS)
    assert [reading.outcome for reading in play.ranged()] == [Outcome.NO_ECHO]


def test_a_distance_beyond_its_range_asks_for_the_unit_and_leaves_it_set_up() -> None:
    play = bench(GOLDEN)
    play.run(60 * MS)
    assert "4660 would be 46.60 m, beyond its range: is its unit another?" in play.ranged()[0].reason
    assert play.state is State.FAULTY
    assert play.sent().count(TEMPERATURE) == 1


def test_another_one_s_late_reply_before_its_own_is_passed_over() -> None:
    play = bench(told(700, address=0x12) + told(300))
    play.run(60 * MS)
    assert [reading.distance for reading in play.ranged()] == [approx(3.0)]


def test_a_garbled_distance_is_invalid() -> None:
    play = bench(told(300)[:-1] + b"\0")
    play.run(35 * MS)
    (reading,) = play.ranged()
    assert reading.outcome is Outcome.INVALID
    assert "noise, or two devices at one address" in reading.reason


@mark.parametrize(("greeting", "state"), [(ETIMEDOUT, State.MISSING), (EPROTO, State.GARBLED)])
def test_one_that_does_not_greet_is_missing_or_garbled(greeting: int, state: State) -> None:
    play = bench(GOLDEN, greeting=greeting)
    play.run(100 * MS)
    assert (play.state, play.ranged()) == (state, [])
    assert "19200 baud" in play.message


def test_silence_of_a_triggered_one_is_one_invalid_reading() -> None:
    play = bench(ETIMEDOUT, triggers=True)
    play.run(100 * MS)
    assert [reading.reason for reading in play.ranged()] == ["not ready in time"]


def test_the_port_is_to_be_opened_at_the_baud_rate_of_the_settings() -> None:
    assert Urm07(ROLE, Urm07.Settings(baud=115_200)).port_options == {"baud": 115_200}


@mark.parametrize(
    "wrong", [{"address": 0x10}, {"address": 0x81}, {"baud": 0}, {"unit_mm": 0.0}, {"no_echo": (-1,)}]
)
def test_impossible_settings_are_refused_by_name(wrong: dict[str, object]) -> None:
    with raises(ValueError, match=f"{next(iter(wrong))} is .*: expected"):
        Urm07.Settings(**wrong)  # type: ignore[arg-type]


def test_a_reach_beyond_its_own_is_refused() -> None:
    with raises(ValueError, match=r"max_m is 11.0: expected 0.0 to 10.0"):
        Urm07(RangerRole("front", 0.2, 11.0, SLOT, SPEED), Urm07.Settings())


def test_it_is_moved_by_one_message() -> None:
    (transfer,) = address_change(0x11, 0x23)
    assert transfer.send == (bytes.fromhex("55AA1101552389"),)
    assert transfer.reply_length is not None
    assert transfer.reply_length(b"\x55") == len(bytes.fromhex("55AA230155CC44"))
    with raises(ValueError, match="address is 129: expected 17 to 128"):
        address_change(0x11, 0x81)


@given(
    lists(one_of(binary(min_size=1, max_size=10), sampled_from([told(300), ETIMEDOUT, EPROTO])), max_size=12),
    sampled_from([True, False]),
)
def test_whatever_it_says_echoes_are_possible_and_it_recovers(
    answers: list[bytes | int], triggers: bool
) -> None:
    play = bench(*answers, told(300), triggers=triggers)
    play.run(4_000 * MS)
    for reading in play.ranged():
        assert (reading.outcome is Outcome.ECHO) == (0.2 <= reading.distance < 4.0)
    play.run(10_000 * MS)
    assert play.state is State.WELL


# The same with the emulated rangers, on the clock that jumps.

URM04 = {"triggers": True, "baud": 115_200}


def joined(count: int, distance: float = 1.0, **settings: object) -> tuple[Joined, list[Urm07Sensor]]:
    """So many on one line, each before a wall of its own, 10 cm apart."""
    options: dict[str, object] = {**settings, "ranging_ns": 30 * MS} if settings else {}
    sensors = [
        Urm07Sensor(
            str(n),
            room(distance + n / 10),
            Random(n),
            Urm07Options(address=0x11 + n, **options),  # type: ignore[arg-type]
        )
        for n in range(count)
    ]
    period_ns = max(count, 2) * 100 * MS
    devices = [
        Urm07(
            RangerRole(str(n), 0.2, 4.0, Slot(period_ns, n * 100 * MS), SPEED),
            Urm07.Settings(address=0x11 + n, **settings),  # type: ignore[arg-type]
        )
        for n in range(count)
    ]
    return Joined(sensors, devices), sensors


@mark.parametrize("settings", [{}, URM04])
@mark.parametrize("distance", [0.3, 1.0, 2.344, 3.9])
def test_it_sees_the_scene_to_half_a_centimetre(distance: float, settings: dict[str, object]) -> None:
    line, _ = joined(1, distance, **settings)
    readings = line.run(2_000 * MS)
    assert len(readings) >= 9
    assert [reading.distance for reading in readings] == approx([distance] * len(readings), abs=0.0051)


def test_in_millimetres_it_sees_it_to_half_a_millimetre() -> None:
    line, _ = joined(1, 2.3444, unit_mm=1.0)
    readings = line.run(2_000 * MS)
    assert [reading.distance for reading in readings] == approx([2.3444] * len(readings), abs=0.0006)


@mark.parametrize("settings", [{}, URM04])
def test_ten_on_a_line_see_each_its_own_wall(settings: dict[str, object]) -> None:
    line, _ = joined(10, **settings)
    line.run(2_000 * MS)
    readings = line.run(3_000 * MS)
    assert 29 <= len(readings) <= 31
    for reading in readings:
        assert reading.distance == approx(1.0 + int(reading.sensor) / 10, abs=0.0051)


@mark.parametrize(
    ("verb", "states"),
    [
        ("off", {State.MISSING}),
        ("unplug", {State.MISSING}),
        ("garbage", {State.GARBLED}),
        ("slow", {State.MISSING, State.STALLED}),
        ("delayed", {State.MISSING}),
        ("address_conflict", {State.GARBLED}),
        ("stuck", {State.WELL}),
        ("wrong", {State.WELL}),
    ],
)
def test_each_fault_has_its_state_and_the_others_go_on(verb: str, states: set[State]) -> None:
    line, sensors = joined(3)
    line.run(2_000 * MS)
    sensors[1].fault(verb, line.clock.now_ns())
    line.run(3_000 * MS)
    readings = line.run(3_000 * MS)
    first, second, third = line.states()
    assert (first, third) == (State.WELL, State.WELL)
    assert second in states
    for n in ("0", "2"):
        own = [reading for reading in readings if reading.sensor == n]
        assert 9 <= len(own) <= 11
        assert [reading.distance for reading in own] == approx([1.0 + int(n) / 10] * len(own), abs=0.0051)
    sensors[1].clear(line.clock.now_ns())
    line.run(4_000 * MS)
    readings = line.run(1_200 * MS)
    assert line.states() == [State.WELL] * 3
    assert {round(reading.distance, 3) for reading in readings if reading.sensor == "1"} == {1.1}


def test_a_bad_contact_comes_and_goes_and_gives_no_wrong_reading() -> None:
    line, sensors = joined(2)
    sensors[0].fault("intermittent", line.clock.now_ns())
    own = [reading for reading in line.run(30_000 * MS) if reading.sensor == "0"]
    assert Outcome.ECHO in {reading.outcome for reading in own}
    assert {round(reading.distance, 3) for reading in own if reading.outcome is Outcome.ECHO} == {1.0}
