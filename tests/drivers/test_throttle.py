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
