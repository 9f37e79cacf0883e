"""Angles of steering: told as they are, whatever was before."""

from math import degrees, pi, radians, tau

import pytest
from hypothesis import given
from hypothesis.strategies import booleans, floats, integers, lists, sampled_from, tuples
from pytest import approx

from echogrid.drivers import registry
from echogrid.drivers.counter import CountedWheel, Scale
from echogrid.drivers.role import Steering, WheelRole
from echogrid.drivers.wheel_angle import WheelAngle

MS = 1_000_000
PER_TURN = 4096
GEARS = sampled_from([1.0, -1.0, 3.5, -12.0])
ZEROS = floats(-4.0, 4.0)
ANGLES = floats(-1.2, 1.2)
COUNTS_APART = 1.1 * tau / PER_TURN


def role(gear: float = 1.0, zero: float = 0.0, most: float = pi / 2.0) -> WheelRole:
    return WheelRole("steering", gear, fastest=10.0, steering=Steering(zero, most))


def told(angle: float, steering: WheelRole, bits: int) -> int:
    """What an absolute encoder of so many bits sends, with its zero at its own zero."""
    assert steering.steering is not None
    turns = (angle + steering.steering.zero) * steering.gear / tau
    return round(turns * PER_TURN) % (1 << bits)


EVENTS = lists(tuples(integers(1, 3000), ANGLES, booleans(), booleans()), min_size=1, max_size=30)


@given(GEARS, ZEROS, EVENTS)
def test_whatever_fails_an_angle_that_is_told_is_the_one_reported(
    gear: float, zero: float, events: list[tuple[int, float, bool, bool]]
) -> None:
    angle, stamp_ns = WheelAngle(gear, 10.0, Steering(zero)), 0
    for pause_ms, stands, gap, restarted in events:
        stamp_ns += pause_ms * MS
        turns = (stands + zero) * gear / tau
        advance = angle.advance(stamp_ns, turns, 0.0, gap, restarted)
        assert advance is None or advance[0] == approx(stands, abs=1e-9)


def test_a_restart_and_a_jump_are_flagged_and_still_told_as_they_are() -> None:
    angle = WheelAngle(1.0, 10.0, Steering())
    assert angle.advance(0, 0.1, 0.0) == approx((0.1 * tau, False))
    assert angle.advance(10 * MS, 0.0, 0.0, restarted=True) == approx((0.0, True))
    assert angle.advance(20 * MS, 0.2, 0.0) is None
    assert angle.advance(30 * MS, 0.2, 0.0) == approx((0.2 * tau, True))


@given(GEARS, ZEROS, lists(ANGLES, min_size=1, max_size=20), sampled_from([16, 24, 32]))
def test_a_count_is_the_angle_nearest_to_straight_ahead_through_wraps_pauses_and_lost_ports(
    gear: float, zero: float, angles: list[float], bits: int
) -> None:
    steering = role(gear, zero)
    wheel = CountedWheel(steering, Scale(1 << bits, PER_TURN))
    for n, stands in enumerate(angles):
        count = told(stands, steering, bits)
        wheel.lost()
        wheel.heard(n * 5_000 * MS)
        readings = wheel.read(n * 5_000 * MS, count, b"")
        assert [reading.angle for reading in readings] == [approx(stands, abs=COUNTS_APART)]


def test_an_encoder_of_one_turn_may_wrap_beside_straight_ahead() -> None:
    wheel = CountedWheel(role(zero=radians(359.0)), Scale(PER_TURN, PER_TURN))
    counts = [4000, 4090, 4095, 0, 5, 100]
    readings = [wheel.read(n * 200 * MS, count, b"")[0] for n, count in enumerate(counts)]
    assert [degrees(reading.angle) for reading in readings] == approx(
        [(count if count < 2048 else count - PER_TURN) / PER_TURN * 360.0 + 1.0 for count in counts], abs=0.05
    )


@pytest.mark.parametrize("gear", [1.0, -2.0])
def test_an_angle_beyond_its_end_is_refused_and_counted(gear: float) -> None:
    steering = role(gear, zero=0.3, most=0.5)
    wheel = CountedWheel(steering, Scale(1 << 16, PER_TURN))
    counts = [told(angle, steering, 16) for angle in (0.4, 0.6, -0.6)]
    assert [len(wheel.read(n * 100 * MS, count, b"")) for n, count in enumerate(counts)] == [1, 0, 0]
    assert wheel.counts["angles out of range"] == 2
    angle = WheelAngle(1.0, 10.0, Steering(most=0.5))
    assert angle.believable(0.49 / tau, 0.0)
    assert not angle.believable(0.51 / tau, 0.0)


def test_a_rate_is_believed_also_where_the_encoder_s_zero_is_out_of_reach() -> None:
    wheel = CountedWheel(role(zero=3.0, most=0.5), Scale(1 << 16, PER_TURN))
    (reading,) = wheel.read(0, round(3.0 / tau * PER_TURN), b"", 0.2)
    assert reading.rate == approx(0.2 * tau)


@pytest.mark.parametrize(
    ("driver", "settings", "reason"),
    [
        ("vesc", {}, "tachometer begins anew at every power-up"),
        ("odrive-0.5", {"counts_per_turn": 8192}, "leave counts_per_turn out"),
    ],
)
def test_a_counter_that_begins_anew_is_refused_with_the_mend(
    driver: str, settings: dict[str, int], reason: str
) -> None:
    make = registry.driver(driver)
    assert make(WheelRole("drive"), make.Settings(**settings))
    with pytest.raises(ValueError, match=reason):
        make(role(), make.Settings(**settings))
