from collections.abc import Sequence
from errno import EIO, EPROTO, ETIMEDOUT

from pytest import mark

from echogrid.drivers.bus import Break, Result, SerialResult, SerialTransfer
from echogrid.drivers.course import Course
from echogrid.drivers.device import State
from echogrid.drivers.make import Fired
from echogrid.drivers.serial_talk import (
    answered,
    ask,
    ask_surely,
    ending_in,
    exactly,
    fired,
    tell,
    trouble_of,
    unanswered,
)

QUESTION = SerialTransfer((b"q",), exactly(2), 5, framed=False)


def result(errno: int = 0, data: bytes = b"", transfer: SerialTransfer = QUESTION) -> SerialResult:
    return SerialResult(transfer, 100, 900, data, errno, 300)


def outcome(
    course: Course[SerialTransfer, Result[SerialTransfer]], results: Sequence[SerialResult]
) -> tuple[Result[SerialTransfer], int]:
    """What comes of a course with these results, and how often it asked."""
    wish = next(course)
    for count, each in enumerate(results, start=1):
        assert wish is QUESTION
        try:
            wish = course.send(each)
        except StopIteration as end:
            return end.value, count
    raise AssertionError("it asks once more")


def test_a_reply_that_is_believed_is_asked_for_once() -> None:
    assert outcome(ask_surely(QUESTION, lambda data: data == b"12"), [result(data=b"12")]) == (
        result(data=b"12"),
        1,
    )


def test_a_reply_that_is_not_believed_counts_if_it_comes_a_second_time() -> None:
    course = ask_surely(QUESTION, lambda data: False)
    assert outcome(course, [result(data=b"12"), result(data=b"12")]) == (result(data=b"12"), 2)


def test_two_replies_that_differ_are_one_of_a_wrong_length() -> None:
    course = ask_surely(QUESTION, lambda data: False)
    told, count = outcome(course, [result(data=b"12"), result(data=b"34")])
    assert (told.errno, told.data, count) == (EPROTO, b"1234", 2)


@mark.parametrize("errno", [ETIMEDOUT, EPROTO])
def test_a_failure_is_not_asked_for_again(errno: int) -> None:
    assert outcome(ask_surely(QUESTION, lambda data: False), [result(errno)]) == (result(errno), 1)
    course = ask_surely(QUESTION, lambda data: False)
    assert outcome(course, [result(data=b"12"), result(errno)]) == (result(errno), 2)


def test_asking_and_telling_are_transfers() -> None:
    length = exactly(4)
    assert next(ask(b"q", length, 7)) == SerialTransfer((b"q",), length, 7)
    assert next(tell(Break(0.002), b"q", echoed=True)) == SerialTransfer((Break(0.002), b"q"), echoed=True)


@mark.parametrize(
    ("heard", "length"), [(b"", 0), (b"x", 0), (b"ab", 2), (b"xab", 3), (b"abx", 0), (b"xxab", 4)]
)
def test_a_reply_may_end_in_a_frame_with_noise_before_it(heard: bytes, length: int) -> None:
    assert ending_in(lambda tail: tail == b"ab", 2)(heard) == length


def test_a_ping_left_when_its_command_had_passed() -> None:
    assert fired(result(), 5) == Fired(300, 5)
    assert fired(result(ETIMEDOUT), 5) == Fired(300, 5, "no reply")
    assert fired(result(data=b"12"), 5).data == b"12"


def test_a_garbled_reply_to_the_command_is_an_answer_and_silence_is_none() -> None:
    assert answered(result(EPROTO, b"?"), 5) == Fired(300, 5, data=b"?")
    assert answered(result(ETIMEDOUT), 5).trouble == "no reply"


@mark.parametrize(
    ("errno", "state", "words"),
    [
        (ETIMEDOUT, State.MISSING, "no reply from address 3: check its power, wires and address"),
        (EIO, State.MISSING, "are RX and TX of the port joined to its one wire?"),
        (EPROTO, State.GARBLED, "a reply of the wrong length (01 02) from address 3: noise, two devices"),
    ],
)
def test_every_failure_is_told_with_what_to_do(errno: int, state: State, words: str) -> None:
    trouble = unanswered("address 3", result(errno, b"\1\2"), 9600)
    assert (trouble.state, words in trouble.message) == (state, True)
    assert trouble_of(result(errno, b"\1\2")) in trouble.message
    assert errno == EIO or "9600 baud" in trouble.message


def test_no_failure_is_no_trouble() -> None:
    assert trouble_of(result()) == ""
