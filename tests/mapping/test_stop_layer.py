from dataclasses import replace
from math import nan, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.stop_layer import StopLayer, StopZone

MS = 1_000_000
ZONE = StopZone(distance=0.5, ahead=pi / 4, hold_ns=1000 * MS)
FRONT = Ranger("front", Pose(0.2), 0.2, 0.05, 4.0)
SIDE = Ranger("side", Pose(0.0, 0.2, pi / 2), 0.2, 0.05, 4.0)


def layer() -> StopLayer:
    return StopLayer((FRONT, SIDE), ZONE)


def told(stamp_ms: int, outcome: Outcome, distance: float = nan, sensor: str = "front") -> RangeReading:
    return RangeReading(stamp_ms * MS, 0, sensor, outcome, distance)


def echoes(*distances: float, every_ms: int = 100) -> list[RangeReading]:
    return [told(number * every_ms, Outcome.ECHO, r) for number, r in enumerate(distances)]


def stops(readings: list[RangeReading], now_ms: int | None = None) -> bool:
    stop = layer()
    for reading in readings:
        stop.take(reading)
    return stop.must_stop(readings[-1].stamp_ns if now_ms is None else now_ms * MS)


@given(st.floats(0.05, 3.99))
def test_one_echo_stops_if_and_only_if_it_is_near(distance: float) -> None:
    assert stops(echoes(distance)) == (0.2 + distance <= 0.5)


def test_what_is_too_close_stops() -> None:
    assert stops([told(0, Outcome.TOO_CLOSE)])


def test_what_is_too_close_stops_however_far_a_ranger_must_see() -> None:
    stop = StopLayer((replace(FRONT, nearest=0.7),), ZONE)
    for reading in (*echoes(1.0, 0.85, 0.72), told(300, Outcome.TOO_CLOSE), told(400, Outcome.TOO_CLOSE)):
        stop.take(reading)
    assert stop.must_stop(400 * MS)


@pytest.mark.parametrize("outcome", [Outcome.NO_ECHO, Outcome.INVALID])
def test_neither_silence_nor_faults_stop_or_clear(outcome: Outcome) -> None:
    assert not stops([told(0, outcome)])
    assert stops([*echoes(0.2), told(100, outcome)])


def test_an_echo_from_beyond_clears() -> None:
    assert not stops(echoes(0.2, 1.0))


def test_without_another_word_it_holds_for_a_while() -> None:
    assert stops(echoes(0.2), 1000)
    assert not stops(echoes(0.2), 1001)


def test_two_that_come_nearer_stop_before_the_third_is_near() -> None:
    assert stops(echoes(0.46, 0.37))
    assert not stops(echoes(0.46, 0.40))


def test_a_jump_is_no_approach() -> None:
    assert not stops(echoes(3.0, 1.0))
    assert not stops(echoes(0.52, 0.36))


def test_echoes_far_apart_in_time_are_no_approach() -> None:
    assert not stops(echoes(1.0, 0.5, every_ms=1001))


def test_only_what_is_ahead_stops() -> None:
    assert not stops([told(0, Outcome.TOO_CLOSE, sensor="side")])


def test_a_turn_that_only_listened_says_nothing() -> None:
    assert not stops([replace(told(0, Outcome.TOO_CLOSE), listened=True)])


def test_a_sensor_that_nobody_knows_says_nothing() -> None:
    assert not stops([told(0, Outcome.TOO_CLOSE, sensor="rear")])
