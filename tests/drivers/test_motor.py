from collections.abc import Sequence
from itertools import pairwise

from hypothesis import given
from hypothesis.strategies import booleans, floats, lists, none, one_of, sampled_from, tuples

from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.motor import AGAIN_NS, PERIOD_NS, PERIOD_S, Motor
from echogrid.drivers.throttle import FRESH_NS, Throttle

ACCELERATION = 5.0


class Words:
    """Commands that can be read."""

    def enable(self) -> Sequence[str]:
        return ("enable",)

    def drive(self, rate: float) -> Sequence[str]:
        return (f"{rate:.6g}",)

    def let_go(self) -> Sequence[str]:
        return ("0", "off")


def throttled() -> tuple[Throttle, Motor[str]]:
    throttle = Throttle(100.0, ACCELERATION)
    return throttle, Motor(throttle, Words())


def steps(motor: Motor[str], start_ns: int, number: int, driven: bool = True, able: bool = True) -> list[str]:
    return [
        word
        for index in range(number)
        for word in motor.step(start_ns + index * PERIOD_NS, driven=driven, able=able)
    ]


def driving(rate: float) -> tuple[Throttle, Motor[str], int]:
    """A motor that turns at that rate, and the time."""
    throttle, motor = throttled()
    throttle.ask(0, 0.0)
    now_ns = 0
    steps(motor, now_ns, 1)
    while (now_ns := now_ns + PERIOD_NS) < 2_000_000_000:
        throttle.ask(now_ns, rate)
        steps(motor, now_ns, 1)
    return throttle, motor, now_ns


def test_without_a_throttle_it_says_nothing_and_wants_no_time() -> None:
    motor = Motor(None, Words())
    assert steps(motor, 0, 10) == []
    assert motor.deadline_ns == NEVER_NS
    assert not motor.waits(0)


def test_before_anything_is_asked_for_it_says_nothing() -> None:
    _, motor = throttled()
    assert steps(motor, 0, 10, driven=False) == []
    assert motor.parting() == ()


def test_it_is_enabled_again_and_again_until_it_says_so() -> None:
    throttle, motor = throttled()
    throttle.ask(0, 0.0)
    assert steps(motor, 0, AGAIN_NS // PERIOD_NS + 1, driven=False) == ["enable", "enable"]
    assert not throttle.obeyed
    assert steps(motor, AGAIN_NS + PERIOD_NS, 2) == ["0", "0"]
    assert throttle.obeyed


def test_it_is_not_enabled_while_it_is_asked_to_turn() -> None:
    throttle, motor = throttled()
    throttle.ask(0, 1.0)
    assert steps(motor, 0, 5, driven=False) == []
    assert motor.waits(0)


def test_one_that_is_enabled_late_does_not_start_while_it_is_asked_to_turn() -> None:
    throttle, motor = throttled()
    throttle.ask(0, 0.0)
    assert steps(motor, 0, 1, driven=False) == ["enable"]
    throttle.ask(AGAIN_NS, 1.0)
    assert steps(motor, AGAIN_NS, 2, driven=False) == []
    assert steps(motor, AGAIN_NS + 2 * PERIOD_NS, 2, driven=True) == []
    assert motor.waits(AGAIN_NS)


def test_one_that_obeys_already_turns_only_after_it_was_asked_to_stand() -> None:
    throttle, motor = throttled()
    throttle.ask(0, 1.0)
    assert steps(motor, 0, 2) == []
    throttle.ask(2 * PERIOD_NS, 0.0)
    assert steps(motor, 2 * PERIOD_NS, 1) == ["0"]


def test_it_speeds_up_gently_and_slows_down_at_once() -> None:
    throttle, motor = throttled()
    throttle.ask(0, 0.0)
    steps(motor, 0, 1)
    throttle.ask(0, 0.25)
    assert steps(motor, PERIOD_NS, 4) == ["0.1", "0.2", "0.25", "0.25"]
    throttle.ask(0, -0.15)
    assert steps(motor, 5 * PERIOD_NS, 3) == ["-0.1", "-0.15", "-0.15"]
    throttle.ask(0, 0.0)
    assert steps(motor, 8 * PERIOD_NS, 1) == ["0"]


def test_a_rate_that_nobody_asks_for_anew_is_zero_after_200_ms_and_stays_it() -> None:
    _, motor, now_ns = driving(3.0)
    asked_ns = now_ns - PERIOD_NS
    words = steps(motor, now_ns, 50)
    fresh = (asked_ns + FRESH_NS - now_ns) // PERIOD_NS + 1
    assert words == ["3"] * fresh + ["0"] * (50 - fresh)


def test_after_a_fault_it_turns_only_when_it_was_asked_to_stand() -> None:
    throttle, motor, now_ns = driving(3.0)
    throttle.ask(now_ns, 3.0)
    assert steps(motor, now_ns, 3, driven=False, able=False) == ["0", "off"]
    assert steps(motor, now_ns + 2 * PERIOD_NS, 2, driven=False) == []
    assert steps(motor, now_ns + 4 * PERIOD_NS, 2, driven=True) == []
    assert motor.waits(now_ns)
    throttle.ask(now_ns, 0.0)
    assert steps(motor, now_ns + 6 * PERIOD_NS, 1, driven=False) == ["enable"]


def test_a_rate_that_is_no_longer_fresh_does_not_ask_it_to_stand() -> None:
    throttle, motor = throttled()
    throttle.ask(0, 3.0)
    assert steps(motor, 2 * FRESH_NS, 5, driven=False) == []
    assert steps(motor, 3 * FRESH_NS, 5, driven=True) == []


def test_one_that_somebody_else_let_go_does_not_start_by_itself() -> None:
    throttle, motor, now_ns = driving(3.0)
    throttle.ask(now_ns, 3.0)
    assert steps(motor, now_ns, 3, driven=False) == []
    assert not throttle.obeyed


def test_released_it_is_let_go_once() -> None:
    throttle, motor, now_ns = driving(3.0)
    throttle.release()
    assert steps(motor, now_ns, 5) == ["0", "off"]
    assert motor.parting() == ()
    assert not throttle.obeyed


def test_at_the_end_it_is_let_go() -> None:
    _, motor, _ = driving(3.0)
    assert motor.parting() == ("0", "off")


def test_with_its_port_lost_it_is_as_at_the_start() -> None:
    throttle, motor, now_ns = driving(3.0)
    motor.lost()
    assert not throttle.obeyed
    throttle.ask(now_ns, 3.0)
    assert steps(motor, now_ns, 3) == []


@given(
    lists(tuples(one_of(none(), sampled_from([0.0]), floats(-50, 50)), booleans(), booleans()), max_size=60)
)
def test_it_never_speeds_up_faster_than_it_may_nor_turns_without_being_asked(
    asked: list[tuple[float | None, bool, bool]],
) -> None:
    throttle, motor = throttled()
    rates = [0.0]
    for number, (rate, driven, able) in enumerate(asked):
        now_ns = number * PERIOD_NS
        if rate is None:
            throttle.release()
        else:
            throttle.ask(now_ns, rate)
        words = [word for word in motor.step(now_ns, driven, able) if word not in ("enable", "off")]
        assert len(words) <= 1
        told = float(words[0]) if words else 0.0
        if told:
            assert driven
            assert able
            assert rate is not None
            assert (told > 0) == (rate > 0)
            assert abs(told) <= abs(rate) * (1 + 1e-5)
        rates.append(told)
    for before, after in pairwise(rates):
        grown = abs(after) - (abs(before) if before * after > 0 else 0.0)
        assert grown <= ACCELERATION * PERIOD_S + 1e-3
