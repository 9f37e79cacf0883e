from dataclasses import replace
from math import nan, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.footprint import Footprint
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


LONG = Footprint.box(-0.3, 0.6, 0.5)
AROUND_LONG = replace(ZONE, footprint=LONG)
BUMPER = Ranger("bumper", Pose(0.6, 0.4), 0.2, 0.05, 4.0)


@given(st.floats(0.05, 3.99))
def test_with_a_footprint_the_zone_begins_at_its_edge(distance: float) -> None:
    stop = StopLayer((BUMPER,), AROUND_LONG)
    stop.take(told(0, Outcome.ECHO, distance, "bumper"))
    assert stop.must_stop(0) == (distance <= 0.5) or distance == approx(0.5)


def test_what_is_before_the_footprint_is_ahead_however_far_to_the_side() -> None:
    """0.45 m to the left and 0.1 m before base_link is 77 deg off, but in the way."""
    wide = replace(ZONE, footprint=Footprint.box(-0.1, 0.05, 0.5))
    corner = Ranger("corner", Pose(0.05, 0.45), 0.2, 0.05, 4.0)
    for zone, stops in ((ZONE, False), (wide, True)):
        stop = StopLayer((corner,), zone)
        stop.take(told(0, Outcome.ECHO, 0.1, "corner"))
        assert stop.must_stop(0) is stops


def test_what_is_beside_the_footprint_is_not_ahead() -> None:
    beside = Ranger("beside", Pose(0.0, 0.5, pi / 2), 0.2, 0.05, 4.0)
    stop = StopLayer((beside,), AROUND_LONG)
    stop.take(told(0, Outcome.ECHO, 0.1, "beside"))
    assert not stop.must_stop(0)
    assert stop.needed == ()


def test_those_are_needed_which_look_into_the_zone() -> None:
    rear = Ranger("rear", Pose(-0.2, 0.0, pi), 0.2, 0.05, 4.0)
    far = Ranger("far", Pose(0.2), 0.2, 0.4, 4.0)
    assert StopLayer((FRONT, SIDE, rear, far), ZONE).needed == ("front",)
    assert StopLayer((BUMPER, rear), AROUND_LONG).needed == ("bumper",)


@given(st.integers(0, 3000), st.sampled_from([Outcome.ECHO, Outcome.NO_ECHO, Outcome.TOO_CLOSE]))
def test_a_needed_ranger_is_silent_when_it_has_told_nothing_for_longer_than_it_may(
    later_ms: int, outcome: Outcome
) -> None:
    stop = layer()
    stop.take(told(0, outcome, 1.0))
    assert stop.silent(later_ms * MS) == (("front",) if later_ms > 1000 else ())


@pytest.mark.parametrize(
    "nothing", [told(900, Outcome.INVALID), replace(told(900, Outcome.ECHO, 1.0), listened=True)]
)
def test_neither_faults_nor_turns_that_only_listened_end_a_silence(nothing: RangeReading) -> None:
    stop = layer()
    stop.take(told(0, Outcome.ECHO, 1.0))
    stop.take(nothing)
    assert stop.silent(1500 * MS) == ("front",)
    stop.take(told(1400, Outcome.NO_ECHO))
    assert stop.silent(1500 * MS) == ()


def test_a_ranger_that_never_told_anything_is_unheard_and_not_silent() -> None:
    stop = layer()
    assert (stop.silent(10_000 * MS), stop.unheard()) == ((), ("front",))
    stop.take(told(0, Outcome.NO_ECHO))
    assert stop.unheard() == ()


@given(
    st.lists(st.tuples(st.integers(0, 500), st.sampled_from(Outcome), st.floats(0.05, 3.9)), max_size=20),
    st.integers(0, 500),
)
def test_one_more_near_echo_always_stops(story: list[tuple[int, Outcome, float]], gap_ms: int) -> None:
    stop, now_ms = layer(), 0
    for step, outcome, distance in story:
        now_ms += step
        stop.take(told(now_ms, outcome, distance))
    now_ms += gap_ms
    stop.take(told(now_ms, Outcome.ECHO, 0.29))
    assert stop.must_stop(now_ms * MS)
    assert stop.must_stop((now_ms + 1000) * MS)
