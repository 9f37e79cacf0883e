from math import tau

from hypothesis import given
from hypothesis.strategies import booleans, floats, integers, lists, tuples
from pytest import approx

from echogrid.drivers.wheel_angle import SLACK_S, WheelAngle

MS = 1_000_000
FASTEST = 50.0
GEARS = floats(0.5, 50) | floats(-50, -0.5)


def test_it_starts_at_the_angle_that_is_reported() -> None:
    assert WheelAngle(2.0, FASTEST).advance(0, 3.0, 0.0) == approx((1.5 * tau, False))


@given(GEARS, lists(floats(-0.01, 0.01), max_size=50))
def test_possible_motion_is_followed_exactly(gear: float, steps: list[float]) -> None:
    angle = WheelAngle(gear, FASTEST)
    turns = 5.0
    for n, step in enumerate(steps):
        turns += step
        assert angle.advance(n * 10 * MS, turns, 0.0) == approx((turns * tau / gear, False), abs=1e-12)


@given(
    GEARS,
    lists(
        tuples(integers(0, 10_000), floats(-1e6, 1e6), floats(-50, 50), booleans(), booleans()), min_size=2
    ),
)
def test_the_angle_never_moves_faster_than_the_wheel_can(
    gear: float, counts: list[tuple[int, float, float, bool, bool]]
) -> None:
    angle = WheelAngle(gear, FASTEST)
    stamp_ns, last_ns, last = 0, 0, 0.0
    for n, (pause_ms, turns, rate, gap, restarted) in enumerate(counts):
        stamp_ns += pause_ms * MS
        if not (advance := angle.advance(stamp_ns, turns, rate, gap, restarted)):
            continue
        now, jumped = advance
        assert (
            n == 0
            or abs(now - last) <= FASTEST * ((stamp_ns - last_ns) * 1e-9 + SLACK_S) + abs(turns) * 1e-5 + 1e-4
        )
        assert not (jumped and abs(now - last) > 1e-4)
        last, last_ns = now, stamp_ns


def test_an_impossible_jump_is_no_motion_and_motion_goes_on_from_there() -> None:
    angle = WheelAngle(1.0, FASTEST)
    angle.advance(0, 10.0, 0.0)
    assert angle.advance(5 * MS, 500.0, 0.0) is None
    assert angle.advance(10 * MS, 500.0, 0.0) == approx((10.0 * tau, True))
    assert angle.advance(20 * MS, 500.01, 0.0) == approx((10.01 * tau, False))


def test_a_jump_that_the_time_allows_is_motion() -> None:
    angle = WheelAngle(1.0, FASTEST)
    angle.advance(0, 10.0, 0.0)
    assert angle.advance(3000 * MS, 30.0, 0.0) == approx((30.0 * tau, False))


def test_a_known_restart_is_no_motion_even_if_it_could_be() -> None:
    angle = WheelAngle(1.0, FASTEST)
    angle.advance(0, 0.3, 0.0)
    assert angle.advance(1000 * MS, 0.0, 0.0, restarted=True) == approx((0.3 * tau, True))


def test_after_a_gap_a_count_near_zero_is_a_restart() -> None:
    angle = WheelAngle(1.0, FASTEST)
    angle.advance(0, 12.0, 0.0)
    assert angle.advance(5000 * MS, 0.01, 0.0, gap=True) == approx((12.0 * tau, True))


def test_after_a_gap_a_wheel_that_was_heading_for_zero_has_turned() -> None:
    angle = WheelAngle(1.0, FASTEST)
    angle.advance(0, 2.0, -1.0)
    assert angle.advance(2000 * MS, 0.01, 0.0, gap=True) == approx((0.01 * tau, False))


def test_after_a_gap_any_other_count_is_motion() -> None:
    angle = WheelAngle(1.0, FASTEST)
    angle.advance(0, 12.0, 0.0)
    assert angle.advance(5000 * MS, 14.0, 0.0, gap=True) == approx((14.0 * tau, False))
