from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.drivers.sdo import ATTEMPTS, WITHIN_NS, SdoAnswer, SdoClient, SdoRead, SdoWrite
from echogrid.drivers.sdo_course import SdoCourse, SdoPilot, do_all

NODE = 5
POSITION, SPEED = SdoRead(0x6064), SdoRead(0x606C)
BEAT = SdoWrite(0x1017, 0, b"\x64\x00")


def read(index: int, value: int) -> bytes:
    return bytes((0x43, *index.to_bytes(2, "little"), 0)) + value.to_bytes(4, "little")


def written(index: int) -> bytes:
    return bytes((0x60, *index.to_bytes(2, "little"), 0)) + bytes(4)


def aborted(index: int, code: int) -> bytes:
    return bytes((0x80, *index.to_bytes(2, "little"), 0)) + code.to_bytes(4, "little")


def indices(frames: tuple[CanFrame, ...]) -> list[int]:
    return [int.from_bytes(frame.data[1:3], "little") for frame in frames]


def test_requests_go_out_one_at_a_time_in_their_order() -> None:
    client = SdoClient(NODE)
    client.ask(POSITION, BEAT)
    assert indices(client.step(0)[1]) == [0x6064]
    assert client.step(1) == (None, ())
    answer = client.take(read(0x6064, 7))
    assert answer is not None and (answer.request, answer.data, answer.trouble) == (POSITION, b"\7\0\0\0", "")
    assert indices(client.step(2)[1]) == [0x1017]
    assert not client.idle
    assert client.take(written(0x1017)) is not None
    assert client.idle and client.deadline_ns == NEVER_NS


def test_a_request_is_repeated_and_then_has_failed() -> None:
    client, now_ns, sent = SdoClient(NODE), 0, 0
    client.ask(POSITION)
    failed = None
    while failed is None:
        failed, frames = client.step(now_ns)
        sent += len(frames)
        now_ns = client.deadline_ns
    assert sent == ATTEMPTS
    assert failed.trouble == "6064h:0: no reply"
    assert client.idle


def test_the_next_request_goes_out_with_the_failure_of_the_one_before() -> None:
    client = SdoClient(NODE, attempts=1)
    client.ask(POSITION, SPEED)
    client.step(0)
    failed, frames = client.step(WITHIN_NS)
    assert failed is not None and failed.request == POSITION
    assert indices(frames) == [0x606C]


def test_a_reply_to_something_else_is_none() -> None:
    client = SdoClient(NODE)
    assert client.take(read(0x6064, 7)) is None
    client.ask(POSITION)
    client.step(0)
    assert client.take(read(0x606C, 7)) is None
    assert client.take(written(0x6064)) is None
    assert client.take(bytes(8)) is None
    assert client.take(read(0x6064, 7)) is not None


def test_a_refusal_is_told_by_name_and_object() -> None:
    client = SdoClient(NODE)
    client.ask(BEAT)
    client.step(0)
    answer = client.take(aborted(0x1017, 0x06010002))
    assert answer is not None and answer.trouble == "1017h:0: can only be read (0x06010002)"


def test_forgotten_requests_have_no_answers() -> None:
    client = SdoClient(NODE)
    client.ask(POSITION, SPEED)
    client.step(0)
    client.forget()
    assert client.idle and client.take(read(0x6064, 7)) is None
    client.ask(SPEED)
    assert indices(client.step(1)[1]) == [0x606C]


@given(st.lists(st.one_of(st.binary(min_size=8, max_size=8), st.integers(0, 400_000_000))))
def test_every_request_has_one_answer_whatever_comes(events: list[bytes | int]) -> None:
    client, now_ns, answers = SdoClient(NODE), 0, list[SdoAnswer]()
    client.ask(POSITION, BEAT, SPEED)
    for event in [*events, *[WITHIN_NS] * (3 * ATTEMPTS + 1)]:
        if isinstance(event, bytes):
            answer = client.take(event)
        else:
            now_ns += event
            answer = client.step(now_ns)[0]
        answers += [answer] if answer else []
    assert [answer.request for answer in answers] == [POSITION, BEAT, SPEED]
    assert client.idle


def replying(pilot: SdoPilot[str], replies: dict[int, bytes]) -> list[int]:
    """Run a course to its end; the objects it asked for."""
    asked: list[int] = []
    now_ns = 0
    while pilot.busy:
        for index in indices(pilot.step(now_ns)):
            asked.append(index)
            if index in replies:
                assert pilot.take(replies[index])
        now_ns += WITHIN_NS
    return asked


def test_a_course_gets_the_answer_to_each_of_its_requests() -> None:
    def course() -> SdoCourse[str]:
        position = yield POSITION
        trouble = yield from do_all([BEAT])
        return f"{position.data.hex()} {trouble}"

    pilot = SdoPilot[str](NODE)
    pilot.start(course())
    assert replying(pilot, {0x6064: read(0x6064, 7), 0x1017: written(0x1017)}) == [0x6064, 0x1017]
    assert pilot.outcome == "07000000 "


def test_a_list_of_requests_ends_at_the_first_that_fails() -> None:
    pilot = SdoPilot[str](NODE)
    pilot.start(do_all([POSITION, BEAT, SPEED]))
    assert replying(pilot, {0x6064: read(0x6064, 7)}) == [0x6064, 0x1017, 0x1017, 0x1017]
    assert pilot.outcome == "1017h:0: no reply"


def test_a_course_that_is_left_asks_no_more() -> None:
    pilot = SdoPilot[str](NODE)
    pilot.start(do_all([POSITION, SPEED]))
    pilot.step(0)
    pilot.stop()
    assert pilot.step(WITHIN_NS) == () and not pilot.take(read(0x6064, 7))
    assert pilot.outcome is None and pilot.deadline_ns == NEVER_NS
