from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from math import isnan
from typing import Any

from hypothesis import given
from hypothesis.strategies import binary, integers, lists, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.device import State
from echogrid.drivers.maxbotix import Maxbotix
from echogrid.drivers.maxbotix_models import MODELS
from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.drivers.role import RangerRole

SPEED = 343.2
ROLE = RangerRole("front", 0.1, 4.0, None, SPEED)
CYCLE_NS = 50_000_000
SECOND = 1_000_000_000


def ranger(model: str = "MB1010", role: RangerRole = ROLE, **settings: Any) -> Maxbotix:
    return Maxbotix(role, Maxbotix.Settings(model, **settings))


def readings(device: Maxbotix, *chunks: bytes) -> list[RangeReading]:
    given = [
        reading for n, chunk in enumerate(chunks) for reading in device.step(n * CYCLE_NS, [chunk]).readings
    ]
    return [reading for reading in given if isinstance(reading, RangeReading)]


@mark.parametrize(
    ("model", "line", "outcome", "distance"),
    [
        ("MB1010", b"R040\r", Outcome.ECHO, 40 * 147e-6 * SPEED / 2),
        ("MB1010", b"R002\r", Outcome.TOO_CLOSE, None),
        ("MB1010", b"R200\r", Outcome.NO_ECHO, None),
        ("MB1010", b"R255\r", Outcome.NO_ECHO, None),
        ("MB1010", b"R256\r", Outcome.INVALID, None),
        ("MB1001", b"R008 P1\r", Outcome.ECHO, 8 * 147e-6 * SPEED / 2),
        ("MB1240", b"R040\r", Outcome.ECHO, 40 * 58e-6 * SPEED / 2),
        ("MB7052", b"R012\r", Outcome.ECHO, 12 * 58e-6 * SPEED / 2),
        ("MB1240", b"R765\r", Outcome.NO_ECHO, None),
        ("MB1261", b"R0040\r", Outcome.ECHO, 40 * 58e-6 * SPEED / 2),
        ("MB1013", b"R0480\r", Outcome.ECHO, 0.48),
        ("MB1403", b"R0480 \r", Outcome.ECHO, 0.48),
        ("MB7363", b"R2257\r", Outcome.ECHO, 2.257),
        ("MB7384", b"R5000\r", Outcome.NO_ECHO, None),
        ("MB7384", b"R5001\r", Outcome.INVALID, None),
        ("MB7383", b"R9999\r", Outcome.NO_ECHO, None),
    ],
)
def test_each_family_has_its_unit_and_its_number_for_nothing(
    model: str, line: bytes, outcome: Outcome, distance: float | None
) -> None:
    (reading,) = readings(ranger(model), line)
    assert reading.outcome is outcome
    assert isnan(reading.distance) if distance is None else reading.distance == approx(distance)
    assert reading.raw == line
    assert bool(reading.reason) == (outcome is Outcome.INVALID)


def test_at_the_speed_of_sound_of_its_label_an_inch_is_an_inch() -> None:
    """147 us there and back, and 58 us for a centimetre."""
    (inches,) = readings(ranger(role=replace(ROLE, speed_of_sound=345.578)), b"R040\r")
    (centimetres,) = readings(ranger("MB1240", replace(ROLE, speed_of_sound=344.828)), b"R040\r")
    assert (inches.distance, centimetres.distance) == (approx(1.016, rel=1e-5), approx(0.4, rel=1e-5))


def test_where_the_speed_of_sound_is_another_only_those_with_a_thermometer_are_left_as_they_are() -> None:
    cold = replace(ROLE, speed_of_sound=SPEED * 0.96)
    for model, line, change in (("MB1010", b"R040\r", 0.96), ("MB7389", b"R1000\r", 1.0)):
        (warm,), (reading,) = readings(ranger(model), line), readings(ranger(model, cold), line)
        assert reading.distance == approx(warm.distance * change)


@mark.parametrize(
    ("line", "metres"), [(b"R040\r", 40 * 147e-6 * SPEED / 2), (b"R255\r", 4.0), (b"R256\r", 0.0)]
)
def test_the_stamp_is_when_the_sound_met_the_obstacle(line: bytes, metres: float) -> None:
    (reading,) = ranger().step(SECOND, [line]).readings
    pinged_ns = SECOND - 5 * 10 * SECOND // 9600 - 44_300_000
    assert reading.stamp_ns == approx(pinged_ns + metres / SPEED * 1e9, abs=2)
    assert reading.stamp_error_ns == 5_000_000


def test_where_readings_are_smoothed_the_stamp_is_older_and_less_sure() -> None:
    (reading,) = ranger("MB7389").step(SECOND, [b"R1000\r"]).readings
    pinged_ns = SECOND - 6 * 10 * SECOND // 9600 - 140_000_000 - 375_000_000
    assert reading.stamp_ns == approx(pinged_ns + 1.0 / SPEED * 1e9, abs=2)
    assert reading.stamp_error_ns == 375_000_000


def test_lag_and_number_for_nothing_are_the_users_if_he_says_so() -> None:
    device = ranger("MB7389", lag_ms=200.0, lag_error_ms=20.0, no_echo=4999)
    (nothing,) = device.step(SECOND, [b"R4999\r"]).readings
    assert nothing.outcome is Outcome.NO_ECHO
    (reading,) = device.step(SECOND, [b"R1000\r"]).readings
    assert reading.stamp_error_ns == 20_000_000
    assert reading.stamp_ns > SECOND - 210_000_000


def test_without_a_model_what_counts_inches_or_centimetres_is_garbled_rather_than_misread() -> None:
    for line in (b"R040\r", b"R008 P1\r", b"R255\r", b"R765\r"):
        device = Maxbotix(ROLE, Maxbotix.Settings())
        assert readings(device, *[line] * 30) == []
        assert device.health(29 * CYCLE_NS).state is State.GARBLED


@mark.parametrize(
    ("model", "hint"), [("mb1010", "did you mean 'MB1010'"), ("HC-SR04", "expected one of MB1000, MB1001")]
)
def test_an_unknown_model_is_refused_with_a_hint(model: str, hint: str) -> None:
    with raises(ValueError, match=hint):
        Maxbotix.Settings(model)


@mark.parametrize("wrong", [{"baud": 0}, {"lag_ms": 10}, {"lag_error_ms": 3000}, {"no_echo": 1000}])
def test_impossible_settings_are_refused_by_name(wrong: dict[str, int]) -> None:
    with raises(ValueError, match=f"{next(iter(wrong))} is .*: expected"):
        Maxbotix.Settings("MB1010", **wrong)


@mark.parametrize("model", MODELS)
def test_more_than_a_model_reaches_is_refused(model: str) -> None:
    reach = MODELS[model].no_echo * MODELS[model].unit.metres
    with raises(ValueError, match=r"max_m is .*: expected"):
        ranger(model, replace(ROLE, farthest=reach * 1.01))
    ranger(model, replace(ROLE, farthest=reach * 0.99))


def test_another_model_than_configured_is_seen_by_its_numbers() -> None:
    device = ranger("MB1010")
    readings(device, b"R410\r")
    health = device.health(0)
    assert health.state is State.FAULTY
    assert "410 is more than a MB1010 says: another model?" in health.message


def test_another_model_than_configured_is_seen_by_its_digits() -> None:
    device = ranger("MB1010")
    assert readings(device, *[b"R1000\r"] * 30) == []
    health = device.health(29 * CYCLE_NS)
    assert health.state is State.GARBLED
    assert "is it a MB1010 (R and 3 digits) at 9600 baud" in health.message


def test_presence_flags_are_counted() -> None:
    device = ranger("MB1001")
    readings(device, b"R008 P0\r", b"R008 P1\r", b"R008 P1\r")
    assert device.health(0).counts["presence flags"] == 2


def bits_on_the_wire(data: bytes) -> Iterator[int]:
    """Level after level: start bit, eight bits, the lowest first, stop bit; and the pause between lines."""
    for byte in data:
        yield from (0, *(byte >> n & 1 for n in range(8)), 1)
    yield from [1] * 30


def heard(levels: list[int]) -> bytes:
    """What a receiver makes of levels, whatever the stop bits are."""
    data, at = bytearray(), 1
    while at + 9 < len(levels):
        if (levels[at - 1], levels[at]) == (1, 0):
            data.append(sum(levels[at + 1 + n] << n for n in range(8)))
            at += 9
        at += 1
    return bytes(data)


@given(lists(integers(0, 255), min_size=1, max_size=4))
def test_an_inverted_signal_gives_no_reading_and_the_hint_to_invert_it(sent: list[int]) -> None:
    device = ranger()
    levels = [level for number in sent for level in bits_on_the_wire(b"R%03d\r" % number)]
    assert heard([1, *levels]) == b"".join(b"R%03d\r" % number for number in sent)
    garbage = heard([1 - level for level in levels])
    assert readings(device, garbage, garbage) == []
    for tenth in range(21):
        device.step(tenth * SECOND // 10, [garbage])
    health = device.health(2 * SECOND)
    assert health.state is State.GARBLED
    assert "inverted, and need an RS-232 port or an inverter" in health.message


def test_what_a_ttl_port_read_of_a_real_mb7066_is_no_line() -> None:
    """The bytes of a question on arduino.stackexchange.com (7976)."""
    assert readings(ranger("MB7066"), bytes((43, 192, 6, 6, 179, 89, 30, 0))) == []


def test_of_lines_that_come_at_once_only_the_last_is_read() -> None:
    device = ranger()
    (reading,) = readings(device, b"R040\rR041\rR042\r")
    assert reading.raw == b"R042\r"
    assert device.health(0).counts["overtaken frames"] == 2


@given(lists(binary(max_size=20), max_size=10), integers(0, 254), lists(integers(1, 4), max_size=4))
def test_behind_any_noise_the_first_line_is_read_however_it_comes(
    noise: list[bytes], inches: int, cuts: list[int]
) -> None:
    device = ranger()
    check_possible(readings(device, *noise))
    line = b"R%03d\r" % inches
    places = [0, *sorted(set(cuts)), 5]
    given = readings(device, *(line[a:b] for a, b in pairwise(places)))
    check_possible(given)
    assert given[-1].raw == line


@given(sampled_from(["MB1010", "MB7389"]), lists(binary(max_size=8) | sampled_from([b"R040\r", b"R0480\r"])))
def test_random_bytes_raise_nothing_and_give_only_possible_readings(model: str, chunks: list[bytes]) -> None:
    check_possible(readings(ranger(model), *chunks))


def check_possible(given: list[RangeReading]) -> None:
    for reading in given:
        assert (reading.outcome is Outcome.ECHO) == (ROLE.nearest <= reading.distance < ROLE.farthest)


def test_behind_a_lost_port_half_a_line_is_forgotten() -> None:
    device = ranger()
    device.step(0, [b"R0"])
    device.lost(0)
    assert [reading.raw for reading in readings(device, b"40\r", b"R041\r")] == [b"R041\r"]


def test_a_park_sonar_may_be_silent_for_longer() -> None:
    for model, state in (("MB1010", State.SILENT), ("MB1001", State.WELL)):
        device = ranger(model)
        device.step(0, [b"R008 P1\r"])
        assert device.health(2 * SECOND).state is state


def test_it_sends_nothing_and_waits_for_nothing() -> None:
    step = ranger().step(0, [b"R040\r"])
    assert (step.send, step.deadline_ns) == ((), NEVER_NS)


def test_the_port_is_to_be_opened_at_the_baud_rate_of_the_settings() -> None:
    assert ranger(baud=57600).port_options == {"baud": 57600}
