from collections.abc import Callable
from errno import ETIMEDOUT

from hypothesis import given
from hypothesis.strategies import booleans, integers, lists, tuples

from echogrid.drivers.bus import NEVER_NS, I2cMessage, I2cResult, I2cTransfer, Result
from echogrid.drivers.course import ANSWER_WITHIN_NS, Course, Pilot

IDLE = I2cTransfer(())
FIRST, SECOND = (I2cTransfer((I2cMessage(address, b"\x00"),)) for address in (1, 2))


def pilot(
    course: Callable[[list[object]], Course[I2cTransfer, None]],
) -> tuple[Pilot[I2cTransfer], list[object]]:
    """A pilot on a course which writes into a list what it lives through."""
    seen: list[object] = []
    started: Pilot[I2cTransfer] = Pilot(IDLE)
    started.start(course(seen), 0)
    return started, seen


def two_transfers(seen: list[object]) -> Course[I2cTransfer, None]:
    seen.append((yield FIRST).data)
    seen.append((yield SECOND).data)
    yield NEVER_NS


def test_a_result_comes_back_from_the_yield_of_its_transfer() -> None:
    flown, seen = pilot(two_transfers)
    assert flown.step(0, []) == (FIRST,)
    assert flown.step(1, [I2cResult(FIRST, 0, 1, b"a")]) == (SECOND,)
    flown.step(2, [I2cResult(SECOND, 1, 2, b"b")])
    assert seen == [b"a", b"b"]


def test_the_result_of_an_equal_transfer_of_somebody_else_is_not_taken() -> None:
    flown, seen = pilot(two_transfers)
    flown.step(0, [])
    twin = I2cTransfer(FIRST.messages)
    assert flown.step(1, [I2cResult(twin, 0, 1, b"x")]) == ()
    assert seen == []


def test_a_transfer_without_a_result_fails_after_a_while_and_is_counted() -> None:
    def course(seen: list[object]) -> Course[I2cTransfer, None]:
        seen.append((yield FIRST).errno)
        yield NEVER_NS

    flown, seen = pilot(course)
    flown.step(0, [])
    assert flown.deadline_ns == ANSWER_WITHIN_NS
    flown.step(ANSWER_WITHIN_NS, [])
    assert (seen, flown.unanswered) == ([ETIMEDOUT], 1)


@given(lists(integers(0, 1000), min_size=1, max_size=20))
def test_waits_are_kept_and_waits_for_the_past_cost_nothing(waits: list[int]) -> None:
    def course(seen: list[object]) -> Course[I2cTransfer, None]:
        for wait in waits:
            yield wait
            seen.append(wait)
        yield NEVER_NS

    flown, seen = pilot(course)
    now_ns = 0
    while flown.deadline_ns < NEVER_NS:
        now_ns = max(now_ns, flown.deadline_ns)
        flown.step(now_ns, [])
    assert len(seen) == len(waits)
    assert now_ns == max(waits)


def test_to_start_anew_leaves_the_old_course_and_its_transfer() -> None:
    flown, seen = pilot(two_transfers)
    flown.step(0, [])
    flown.start(two_transfers(seen), 5)
    assert flown.step(5, [I2cResult(FIRST, 0, 1, b"old")]) == (FIRST,)
    assert seen == []


def test_to_be_woken_ends_a_wait_but_not_a_transfer() -> None:
    def course(seen: list[object]) -> Course[I2cTransfer, None]:
        yield NEVER_NS
        seen.append("woken")
        yield FIRST
        seen.append("answered")
        yield NEVER_NS

    flown, seen = pilot(course)
    flown.wake()
    assert seen == []
    flown.step(0, [])
    flown.wake()
    flown.wake()
    assert seen == ["woken"]
    assert flown.step(1, []) == (FIRST,)


@given(lists(tuples(booleans(), integers(0, ANSWER_WITHIN_NS)), max_size=30))
def test_there_is_never_more_than_one_transfer_under_way(answers: list[tuple[bool, int]]) -> None:
    def course(seen: list[object]) -> Course[I2cTransfer, None]:
        while True:
            seen.append((yield I2cTransfer(FIRST.messages)).errno)

    flown, seen = pilot(course)
    now_ns, pending = 0, list(flown.step(0, []))
    for answered, after_ns in answers:
        assert len(pending) == 1
        now_ns += after_ns
        results: list[Result[I2cTransfer]] = [Result(pending[0], now_ns, now_ns)] if answered else []
        sent = flown.step(now_ns, results)
        pending = list(sent) or pending
    assert len(seen) == sum(answered for answered, _ in answers) + flown.unanswered
