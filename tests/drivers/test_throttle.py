from pytest import mark

from echogrid.drivers.throttle import FRESH_NS, Throttle


def test_until_a_rate_is_asked_for_there_is_none() -> None:
    assert Throttle(10.0, 5.0).rate(0) is None


def test_a_rate_that_is_not_asked_for_anew_becomes_zero_after_200_ms() -> None:
    throttle = Throttle(10.0, 5.0)
    throttle.ask(1_000, 3.0)
    assert FRESH_NS == 200_000_000
    assert [throttle.rate(1_000 + age_ns) for age_ns in (0, FRESH_NS, FRESH_NS + 1, 10 * FRESH_NS)] == [
        3.0,
        3.0,
        0.0,
        0.0,
    ]


@mark.parametrize(("asked", "given"), [(99.0, 10.0), (-99.0, -10.0), (-4.0, -4.0)])
def test_no_rate_is_higher_than_the_highest(asked: float, given: float) -> None:
    throttle = Throttle(10.0, 5.0)
    throttle.ask(0, asked)
    assert throttle.rate(0) == given


def test_released_there_is_none_again() -> None:
    throttle = Throttle(10.0, 5.0)
    throttle.ask(0, 3.0)
    throttle.release()
    assert throttle.rate(0) is None


def test_after_a_pause_zero_must_be_asked_for_before_the_wheel_turns_again() -> None:
    throttle = Throttle(10.0, 5.0)
    throttle.ask(0, 3.0)
    for step in range(1, 5):
        now_ns = FRESH_NS + step
        throttle.ask(now_ns, 3.0)
        assert throttle.rate(now_ns) == 0.0
    throttle.ask(FRESH_NS + 5, 0.0)
    throttle.ask(FRESH_NS + 6, 3.0)
    assert throttle.rate(FRESH_NS + 6) == 3.0


def test_a_pause_while_standing_bars_as_well_and_a_release_does_not() -> None:
    throttle = Throttle(10.0, 5.0)
    throttle.ask(0, 0.0)
    throttle.ask(FRESH_NS + 1, 3.0)
    assert throttle.rate(FRESH_NS + 1) == 0.0
    throttle.release()
    throttle.ask(9 * FRESH_NS, 3.0)
    assert throttle.rate(9 * FRESH_NS) == 3.0
