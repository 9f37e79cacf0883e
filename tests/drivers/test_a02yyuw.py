from dataclasses import replace
from itertools import pairwise
from math import isnan

from hypothesis import given
from hypothesis.strategies import binary, integers, lists
from pytest import approx, mark, raises

from echogrid.drivers.a02yyuw import A02yyuw
from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.device import Level, State
from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.drivers.role import RangerRole

ROLE = RangerRole("front", 0.03, 4.5, None, 343.0)
GOLDEN = bytes.fromhex("FF07A1A7")
CYCLE_NS = 100_000_000


def ranger(settings: A02yyuw.Settings | None = None) -> A02yyuw:
    """One which has believed a frame already."""
    device = A02yyuw(ROLE, settings or A02yyuw.Settings())
    device.step(0, [GOLDEN])
    return device


def readings(device: A02yyuw, *chunks: bytes) -> list[RangeReading]:
    given = [
        reading for n, chunk in enumerate(chunks) for reading in device.step(n * CYCLE_NS, [chunk]).readings
    ]
    return [reading for reading in given if isinstance(reading, RangeReading)]


def test_the_first_frame_only_confirms_the_second() -> None:
    device = A02yyuw(ROLE, A02yyuw.Settings())
    assert device.step(0, [GOLDEN]).readings == ()
    assert len(device.step(CYCLE_NS, [GOLDEN]).readings) == 1


@mark.parametrize(
    ("text", "outcome", "distance"),
    [
        ("FF 07 A1 A7", Outcome.ECHO, 1.953),
        ("FF 06 B5 BA", Outcome.ECHO, 1.717),
        ("FF 00 E0 DF", Outcome.ECHO, 0.224),
        ("FF 00 00 FF", Outcome.NO_ECHO, None),
        ("FF FF FD FB", Outcome.NO_ECHO, None),
        ("FF FF FE FC", Outcome.INVALID, None),
        ("FF 00 1D 1C", Outcome.TOO_CLOSE, None),
        ("FF 11 94 A4", Outcome.NO_ECHO, None),
    ],
)
def test_the_known_frames_have_their_meaning(text: str, outcome: Outcome, distance: float | None) -> None:
    (reading,) = readings(ranger(), bytes.fromhex(text))
    assert reading.outcome is outcome
    assert isnan(reading.distance) if distance is None else reading.distance == approx(distance)
    assert reading.raw == bytes.fromhex(text)
    assert bool(reading.reason) == (outcome is Outcome.INVALID)


# As logged from the ports of real ones: a JSN-SR04T sending unasked (arendst/Tasmota#16613), an A01NYUB
# (esphome/issues#5182), a JSN-SR04T below its blanking distance (esphome/issues#5775).
CAPTURES = {
    "FF06B5BAFF06B6BBFF06B6BBFF06BEC3FF06B6BBFF06B6BBFF06B1B6FF06B1B6FF06B6BBFF06B6BBFF06B1B6FF06BABFFF06B6BB"
    "FF06B6BBFF06B6BBFF06B6BBFF06B6BBFF06B1B6FF06B6BBFF06BEC3FF06B6BBFF06B6BB00": (
        *(1718, 1718, 1726, 1718, 1718, 1713, 1713, 1718, 1718, 1713, 1722, 1718),
        *(1718, 1718, 1718, 1718, 1713, 1718, 1726, 1718, 1718),
    ),
    "FF039193FF039092FF039193FF039193FF039294FF039294FF039193": (912, 913, 913, 914, 914, 913),
    "FF00E0DFFF00E0DFFF00E0DF": (224, 224),
}


@mark.parametrize(("text", "millimetres"), CAPTURES.items(), ids=["jsn-sr04t", "a01nyub", "near"])
def test_what_was_captured_from_real_ones_is_read(text: str, millimetres: tuple[int, ...]) -> None:
    device = A02yyuw(ROLE, A02yyuw.Settings())
    capture = bytes.fromhex(text)
    frames = [capture[at : at + 4] for at in range(0, len(capture), 4)]
    assert [round(reading.distance * 1000) for reading in readings(device, *frames)] == list(millimetres)


def test_a_board_that_leaves_the_header_out_of_the_sum_is_told_so() -> None:
    device = A02yyuw(ROLE, A02yyuw.Settings(header_summed=False))
    assert [reading.distance for reading in readings(device, bytes.fromhex("FF00DEDE") * 2)] == [0.222]
    assert "without the header" in garbled(device)
    assert "with the header" in garbled(A02yyuw(ROLE, A02yyuw.Settings()))


def garbled(device: A02yyuw) -> str:
    """What it says of noise that lasts."""
    for tenth in range(10, 31):
        device.step(tenth * CYCLE_NS, [b"noise"])
    return device.health(30 * CYCLE_NS).message


def test_each_part_has_its_lag_and_its_codes_and_the_user_has_the_last_word() -> None:
    assert A02yyuw.Settings(part="a01nyub").lags_ms == (225.0, 75.0)
    assert A02yyuw.Settings(part="a01nyub", lag_ms=150).lags_ms == (150, 75.0)
    assert A02yyuw.Settings(part="dyp-a02").chosen.no_echo_mm == (0, 0xFFFD)
    assert A02yyuw.Settings(part="dyp-a02", no_echo_mm=(5500,)).chosen.no_echo_mm == (5500,)
    assert A02yyuw.Settings(part="dyp-a02", no_echo_mm=(5500,)).chosen.invalid_mm == (0xFFFE,)


def test_more_than_the_part_reaches_is_refused() -> None:
    far = replace(ROLE, farthest=6.0)
    with raises(ValueError, match=r"max_m is 6\.0: expected 0\.0 to 4\.5"):
        A02yyuw(far, A02yyuw.Settings())
    A02yyuw(far, A02yyuw.Settings(part="jsn-sr04t"))
    A02yyuw(far, A02yyuw.Settings(reach_m=6.0))


def test_an_unknown_part_is_refused_with_those_which_there_are() -> None:
    with raises(ValueError, match="part is 'a03': expected one of a02yyuw, a01nyub, me007ys, jsn-sr04t"):
        A02yyuw.Settings(part="a03")  # type: ignore[arg-type] # the point of the test


def test_a_part_whose_no_echo_is_its_longest_distance_is_told_so() -> None:
    device = ranger(A02yyuw.Settings(no_echo_mm=(1953,)))
    assert readings(device, GOLDEN)[0].outcome is Outcome.NO_ECHO


def test_the_stamp_is_the_arrival_less_the_transfer_and_the_lag() -> None:
    device = ranger(A02yyuw.Settings(lag_ms=50, lag_error_ms=10))
    (reading,) = device.step(1_000_000_000, [GOLDEN]).readings
    assert reading.stamp_ns == 1_000_000_000 - 50_000_000 - 4_166_666
    assert reading.stamp_error_ns == 10_000_000


def test_of_frames_that_come_at_once_only_the_last_is_read() -> None:
    device = ranger()
    (reading,) = readings(device, bytes.fromhex("FF06B5BA") * 3 + GOLDEN)
    assert reading.raw == GOLDEN
    assert device.health(0).counts["overtaken frames"] == 3


def test_behind_noise_the_first_frame_is_not_believed() -> None:
    assert [r.raw for r in readings(ranger(), b"\x42" + GOLDEN, GOLDEN)] == [GOLDEN]


def test_behind_a_lost_port_the_first_frame_is_not_believed() -> None:
    device = ranger()
    device.step(0, [GOLDEN[:2]])
    device.lost(0)
    assert len(readings(device, GOLDEN, GOLDEN)) == 1


def test_bytes_that_dribble_in_make_a_frame() -> None:
    assert len(readings(ranger(), *(bytes([byte]) for byte in GOLDEN))) == 1


@given(lists(binary(max_size=20), max_size=20))
def test_random_bytes_raise_nothing_and_give_only_possible_readings(chunks: list[bytes]) -> None:
    check_possible(readings(ranger(), *chunks))


@given(lists(binary(max_size=20), max_size=10), integers(0, 4499), lists(integers(1, 7), max_size=7))
def test_behind_any_noise_the_second_frame_is_read_however_it_comes(
    noise: list[bytes], millimetres: int, cuts: list[int]
) -> None:
    device = A02yyuw(ROLE, A02yyuw.Settings(no_echo_mm=(), invalid_mm=()))
    check_possible(readings(device, *noise))
    frame = bytes((0xFF, *divmod(millimetres, 256), (0xFF + sum(divmod(millimetres, 256))) % 256))
    places = [0, *sorted(set(cuts)), 8]
    given = readings(device, *((frame * 2)[a:b] for a, b in pairwise(places)))
    check_possible(given)
    assert given[-1].raw == frame


@given(integers(0, 39), integers(0, 255))
def test_a_wrong_byte_costs_two_frames_at_most(place: int, value: int) -> None:
    stream = bytearray(GOLDEN * 10)
    stream[place] = value
    given = readings(ranger(), *(bytes(stream[n : n + 4]) for n in range(0, 40, 4)))
    check_possible(given)
    assert len([reading for reading in given if reading.raw == GOLDEN]) >= 8


def check_possible(given: list[RangeReading]) -> None:
    for reading in given:
        assert (reading.outcome is Outcome.ECHO) == (ROLE.nearest <= reading.distance < ROLE.farthest)
        assert len(reading.raw) == 4


def test_it_sends_nothing_and_waits_for_nothing() -> None:
    step = ranger().step(0, [GOLDEN])
    assert (step.send, step.deadline_ns) == ((), NEVER_NS)


def test_health_tells_ranging_from_noise_and_silence() -> None:
    device = A02yyuw(ROLE, A02yyuw.Settings())
    assert device.health(0).level is Level.STALE
    readings(device, GOLDEN, GOLDEN)
    assert device.health(CYCLE_NS).level is Level.OK
    for tenth in range(10, 31):
        device.step(tenth * CYCLE_NS, [b"noise"])
    assert device.health(3_000_000_000).level is Level.ERROR
    assert "9600 baud" in device.health(3_000_000_000).message
    assert device.health(5_000_000_000).level is Level.STALE


def test_while_the_first_bytes_come_it_is_being_set_up() -> None:
    device = A02yyuw(ROLE, A02yyuw.Settings())
    device.step(0, [GOLDEN])
    assert device.health(0).state is State.SETTING_UP
    device.step(CYCLE_NS, [GOLDEN])
    assert device.health(CYCLE_NS).state is State.WELL


def test_health_warns_of_interference() -> None:
    device = ranger()
    readings(device, bytes.fromhex("FFFFFEFC"))
    assert device.health(0).level is Level.WARN
    assert "0xfffe" in device.health(0).message


def test_bad_frames_are_counted() -> None:
    device = ranger()
    readings(device, bytes.fromhex("FF07A1A8"))
    assert device.health(0).counts["bad frames"] == 1


@mark.parametrize(
    "wrong",
    [{"baud": 0}, {"lag_ms": -1}, {"lag_error_ms": 3000}, {"no_echo_mm": (70000,)}, {"invalid_mm": (-1,)}],
)
def test_impossible_settings_are_refused_by_name(wrong: dict[str, int]) -> None:
    with raises(ValueError, match=f"{next(iter(wrong))} is .*: expected"):
        A02yyuw.Settings(**wrong)  # type: ignore[arg-type] # the point of the test


def test_the_port_is_to_be_opened_at_the_baud_rate_of_the_settings() -> None:
    assert A02yyuw(ROLE, replace(A02yyuw.Settings(), baud=19200)).port_options == {"baud": 19200}


def test_the_first_bytes_after_a_silence_are_no_garbage_yet() -> None:
    device = ranger()
    device.step(CYCLE_NS, [GOLDEN])
    assert device.health(CYCLE_NS).state is State.WELL
    device.step(100 * CYCLE_NS, [GOLDEN[:2]])
    assert device.health(100 * CYCLE_NS).state is State.SETTING_UP
    device.lost(101 * CYCLE_NS)
    assert device.health(101 * CYCLE_NS).state is State.SILENT
    device.step(102 * CYCLE_NS, [GOLDEN[:2]])
    assert device.health(102 * CYCLE_NS).state is State.SETTING_UP
