from collections.abc import Callable
from errno import EIO, EPROTO, ETIMEDOUT
from itertools import pairwise
from typing import Any

from hypothesis import given
from hypothesis.strategies import (
    DataObject,
    binary,
    booleans,
    composite,
    data,
    integers,
    lists,
    sampled_from,
    tuples,
)
from pytest import approx, mark

from echogrid.drivers.bus import NEVER_NS, Break, SerialTransfer
from echogrid.drivers.conversation import HELD_NS, Conversation
from echogrid.drivers.owed import LATE_NS
from echogrid.drivers.serial_talk import SILENCE, exactly
from echogrid.drivers.talk import LATENCY_NS, PAUSE_BYTES, duration_ns, longest_ns

from .serial_bench import MS, Asker, Played

BYTE_NS = 11 * 1_000_000_000 // 9600
REPLY_NS = 2 * BYTE_NS
WITHIN_NS = 10 * MS
PAIR = exactly(2)


def pair(request: bytes, within_ns: int = WITHIN_NS) -> SerialTransfer:
    """A request whose reply is two bytes, by nothing but a pause."""
    return SerialTransfer((request,), PAIR, within_ns, framed=False)


def framed(request: bytes, length: int = 4, within_ns: int = WITHIN_NS) -> SerialTransfer:
    return SerialTransfer((request,), exactly(length), within_ns)


def told(request: bytes) -> SerialTransfer:
    return SerialTransfer((request,))


def after(delay_ns: int, reply: bytes) -> Callable[[bytes, int], list[tuple[int, bytes]]]:
    """Whoever is asked replies so, that much later than the request has passed."""
    return lambda request, now_ns: [(len(request) * BYTE_NS + delay_ns, reply)]


def only(request: bytes) -> Callable[[bytes, int], list[tuple[int, bytes]]]:
    """Nobody but that one is there."""
    return lambda asked, now_ns: after(MS, b"12")(asked, now_ns) if asked == request else []


def after_all_but(request: bytes) -> Callable[[bytes, int], list[tuple[int, bytes]]]:
    """All are there but that one."""
    return lambda asked, now_ns: after(MS, b"12")(asked, now_ns) if asked != request else []


def one(transfer: SerialTransfer, play: Callable[[Asker], Played]) -> tuple[int, bytes, int]:
    """errno and reply of a transfer, and when it was over."""
    asker = Asker("one", (0, transfer))
    play(asker).run(2_000 * MS)
    (result,) = asker.results
    return result.errno, result.data, asker.ends_ns[0]


def test_what_is_not_answered_is_over_when_it_has_passed() -> None:
    errno, reply, end_ns = one(told(b"abc"), lambda asker: Played([asker]))
    assert (errno, reply, end_ns) == (0, b"", 3 * BYTE_NS)


def test_a_break_takes_its_time_and_goes_out_before_the_bytes() -> None:
    asker = Asker("one", (0, SerialTransfer((Break(0.002), b"ab"))))
    line = Played([asker])
    line.run(100 * MS)
    assert [item for _, item in line.sent] == [Break(0.002), b"ab"]
    assert asker.results[0].sent_ns == asker.ends_ns[0] == 2 * MS + 2 * BYTE_NS


def test_a_framed_reply_ends_the_transfer_with_its_last_byte() -> None:
    errno, reply, end_ns = one(framed(b"q"), lambda a: Played([a], after(3 * MS, b"1234")))
    assert (errno, reply, end_ns) == (0, b"1234", BYTE_NS + 3 * MS)


def test_a_reply_without_a_frame_ends_when_nothing_follows_it() -> None:
    errno, reply, end_ns = one(pair(b"q"), lambda a: Played([a], after(3 * MS, b"12")))
    assert (errno, reply, end_ns) == (0, b"12", BYTE_NS + 3 * MS + PAUSE_BYTES * BYTE_NS)


@mark.parametrize("make", [pair, lambda request: framed(request, 2)])
def test_an_extra_byte_spoils_a_reply(make: Callable[[bytes], SerialTransfer]) -> None:
    assert one(make(b"q"), lambda a: Played([a], after(MS, b"123")))[:2] == (EPROTO, b"123")


def test_an_extra_byte_that_comes_apart_spoils_a_reply_without_a_frame() -> None:
    def dribble(request: bytes, now_ns: int) -> list[tuple[int, bytes]]:
        return [(2 * BYTE_NS + n * BYTE_NS, bytes((n,))) for n in range(3)]

    assert one(pair(b"q"), lambda a: Played([a], dribble))[:2] == (EPROTO, b"\0\1\2")


def test_a_reply_that_an_adapter_hands_over_in_two_parts_is_one() -> None:
    def parts(request: bytes, now_ns: int) -> list[tuple[int, bytes]]:
        return [(2 * BYTE_NS, b"1"), (2 * BYTE_NS + 16 * MS, b"2")]

    assert one(pair(b"q"), lambda a: Played([a], parts))[:2] == (0, b"12")


@mark.parametrize("transfer", [pair(b"q"), framed(b"q")])
def test_silence_times_out(transfer: SerialTransfer) -> None:
    errno, reply, end_ns = one(transfer, lambda a: Played([a]))
    assert (errno, reply, end_ns) == (ETIMEDOUT, b"", BYTE_NS + WITHIN_NS + LATENCY_NS)


@mark.parametrize("transfer", [pair(b"q"), framed(b"q")])
def test_a_part_of_a_reply_is_of_a_wrong_length(transfer: SerialTransfer) -> None:
    assert one(transfer, lambda a: Played([a], after(MS, b"1")))[:2] == (EPROTO, b"1")


def test_a_host_that_was_held_up_finds_the_reply_that_came_in_time() -> None:
    asker = Asker("one", (0, framed(b"q")))
    line = Played([asker], after(3 * MS, b"1234"))
    delays = iter([0, 200 * MS])
    line.stall_ns = lambda: next(delays, 0)
    line.run(1_000 * MS)
    assert [(result.errno, result.data) for result in asker.results] == [(0, b"1234")]


def test_time_is_up_only_when_a_look_after_the_deadline_brings_nothing() -> None:
    line = Conversation("line", [asker := Asker("one", (0, framed(b"q")))])
    deadline_ns = line.step(0, []).deadline_ns
    again = line.step(deadline_ns + 50 * MS, [])
    assert (asker.results, again.deadline_ns <= deadline_ns + 50 * MS) == ([], True)
    line.step(deadline_ns + 50 * MS, [b"1234"])
    assert asker.results[0].errno == 0


def test_a_look_that_brings_a_part_is_followed_by_another() -> None:
    line = Conversation("line", [asker := Asker("one", (0, framed(b"q")))])
    late_ns = line.step(0, []).deadline_ns + MS
    for chunks in ([], [b"12"], [b"34"]):
        line.step(late_ns, chunks)
    assert [(result.errno, result.data) for result in asker.results] == [(0, b"1234")]


@mark.parametrize("make", [pair, lambda request: framed(request, 2), lambda request: framed(request, 1)])
def test_nothing_is_over_before_the_request_has_passed(make: Callable[[bytes], SerialTransfer]) -> None:
    """A line may be quicker than it is thought to be."""
    asker = Asker("one", (0, make(b"12345678")))
    Played([asker], coming=[(MS, b"12")]).run(1_000 * MS)
    assert asker.ends_ns == [8 * BYTE_NS]


@mark.parametrize("noise", [b"", b"\0", b"\0\xfe"])
def test_one_s_own_echo_is_taken_off_with_what_a_break_looks_like(noise: bytes) -> None:
    def echoed(request: bytes, now_ns: int) -> list[tuple[int, bytes]]:
        return [(len(request) * BYTE_NS, noise + request), (3 * BYTE_NS + MS, b"12")]

    for transfer, expected in (
        (SerialTransfer((Break(0.003), b"\1\x5e"), PAIR, WITHIN_NS, echoed=True, framed=False), b"12"),
        (SerialTransfer((Break(0.003), b"\1\x51"), echoed=True), b""),
    ):
        assert one(transfer, lambda a: Played([a], echoed))[:2] == (0, expected)


@mark.parametrize("reply_length", [None, PAIR])
def test_an_echo_that_does_not_come_is_told_from_a_missing_reply(
    reply_length: Callable[[bytes], int] | None,
) -> None:
    transfer = SerialTransfer((b"\1\x5e",), reply_length, WITHIN_NS, echoed=True, framed=False)
    assert one(transfer, lambda a: Played([a], after(MS, b"12")))[0] == EIO
    echo = SerialTransfer((b"\1\x5e",), PAIR, WITHIN_NS, echoed=True, framed=False)
    assert one(echo, lambda a: Played([a], after(0, b"\1\x5e")))[0] == ETIMEDOUT


def test_what_comes_when_nobody_was_asked_is_thrown_away() -> None:
    line = Played([a := Asker("one", (50 * MS, pair(b"q")))], after(MS, b"12"), [(10 * MS, b"stray")])
    line.run(1_000 * MS)
    assert a.results[0].data == b"12"
    assert line.line.stray_bytes == 5


def test_what_a_port_held_before_a_request_is_no_reply_to_it() -> None:
    asker = Asker("one", (50 * MS, pair(b"q")))
    line = Conversation("line", [asker])
    line.step(0, [])
    first = line.step(50 * MS, [b"older"])
    assert (first.send, first.deadline_ns) == ((), 50 * MS)
    assert line.step(50 * MS, [b"rest"]).send == (b"q",)


def test_quiet_before_a_request_counts_from_the_last_byte_on_the_line() -> None:
    quiet = SerialTransfer((b"q",), exactly(1), WITHIN_NS, quiet_ns=4 * MS)
    asker = Asker("one", (0, told(b"a")), (0, quiet))
    line = Played([asker], coming=[(BYTE_NS + 3 * MS, b"x")])
    line.run(1_000 * MS)
    assert line.sent == [(0, b"a"), (BYTE_NS + 7 * MS, b"q")]


def test_a_lost_port_ends_what_is_under_way_and_what_waits() -> None:
    askers = [Asker(name, (0, framed(b"q"))) for name in "ab"]
    line = Conversation("line", askers)
    assert line.step(0, []).send == (b"q",)
    line.lost(MS)
    assert [asker.losses for asker in askers] == [1, 1]
    line.step(2 * MS, [b"1234"])
    step = line.step(2 * MS, [])
    assert (step.send, [asker.results for asker in askers]) == ((), [[], []])


def test_a_transfer_of_nothing_is_over_at_once() -> None:
    assert one(SILENCE, lambda a: Played([a])) == (0, b"", 0)


def test_a_result_goes_to_the_one_that_asked() -> None:
    same = pair(b"q")
    askers = [Asker("a", (0, same)), Asker("b", (0, same))]
    Played(askers, after(MS, b"12")).run(1_000 * MS)
    assert [len(asker.results) for asker in askers] == [1, 1]


def test_one_that_did_not_reply_is_not_asked_again_before_its_reply_can_t_come_any_more() -> None:
    askers = [Asker("dead", (0, pair(b"d")), (0, pair(b"d"))), Asker("other", (40 * MS, pair(b"o")))]
    line = Played(askers, only(b"o"))
    line.run(1_000 * MS)
    timed_out_ns = BYTE_NS + WITHIN_NS + LATENCY_NS
    assert [at_ns for at_ns, item in line.sent if item == b"d"] == [0, timed_out_ns + LATE_NS]
    assert line.sent[1] == (40 * MS, b"o")


def test_alone_on_its_line_a_device_is_asked_whenever_it_wants() -> None:
    line = Played([Asker("alone", (0, pair(b"d")), (0, pair(b"d")))])
    line.run(1_000 * MS)
    assert line.sent[1] == (BYTE_NS + WITHIN_NS + LATENCY_NS, b"d")


def test_one_that_did_not_reply_waits_for_a_gap_between_the_others_but_not_for_ever() -> None:
    dead = Asker("dead", (0, pair(b"d")), (0, pair(b"d")))
    busy = Asker("busy", *((n * 20 * MS, told(b"o")) for n in range(100)))
    line = Played([dead, busy])
    line.run(1_900 * MS)
    second_ns = [at_ns for at_ns, item in line.sent if item == b"d"][1]
    assert second_ns == approx(BYTE_NS + WITHIN_NS + LATENCY_NS + LATE_NS + HELD_NS, abs=5 * MS)
    late = [at_ns % (20 * MS) for at_ns, item in line.sent if item == b"o" and at_ns < second_ns]
    assert max(late[2:]) == 0


def test_the_turns_of_others_that_fail_are_no_reason_to_wait() -> None:
    dead = Asker("dead", (0, pair(b"d")), (0, pair(b"d")))
    other = Asker("other", (40 * MS, pair(b"o")), (345 * MS, pair(b"o")))
    line = Played([dead, other])
    line.run(1_000 * MS)
    again_ns = BYTE_NS + WITHIN_NS + LATENCY_NS + LATE_NS
    assert again_ns < 345 * MS
    assert [at_ns for at_ns, item in line.sent if item == b"d"] == [0, again_ns]


def test_what_is_not_answered_goes_first() -> None:
    """It may be a ping in its turn; an answer can wait."""
    askers = [
        Asker(name, (at_ns, wish))
        for name, at_ns, wish in (
            ("busy", 0, framed(b"x")),
            ("a", MS, framed(b"a")),
            ("b", MS, framed(b"b")),
            ("fires", 2 * MS, told(b"f")),
        )
    ]
    line = Played(askers, after(3 * MS, b"1234"))
    line.run(1_000 * MS)
    assert [item for _, item in line.sent] == [b"x", b"f", b"a", b"b"]


def test_one_that_garbles_its_reply_waits_for_a_gap_too_but_not_for_its_reply() -> None:
    noisy = Asker("noisy", (0, pair(b"n")), (0, pair(b"n")))
    other = Asker("other", (25 * MS, told(b"o")))
    line = Played([noisy, other], lambda request, now_ns: after(MS, b"123")(request, now_ns))
    line.run(1_000 * MS)
    assert [item for _, item in line.sent] == [b"n", b"o", b"n"]
    assert line.sent[1][0] == 25 * MS
    assert line.sent[2][0] == 25 * MS + BYTE_NS


def test_where_a_silent_one_s_reply_may_still_come_a_reply_without_a_frame_is_asked_for_twice() -> None:
    other = Asker("other", *((n * 100 * MS, pair(b"o")) for n in range(1, 7)))
    third = Asker("third", (100 * MS, framed(b"t", 2)))
    line = Played([Asker("dead", (0, pair(b"d"))), other, third], after_all_but(b"d"))
    line.run(1_000 * MS)
    assert [result.data for result in other.results] == [b"12"] * 6
    assert [item for _, item in line.sent][:5] == [b"d", b"o", b"o", b"t", b"o"]
    assert sum(item == b"o" for _, item in line.sent) == 3 * 2 + 3


def test_a_reply_that_is_another_the_second_time_is_none() -> None:
    said = iter([b"12", b"34"])
    other = Asker("other", (100 * MS, pair(b"o")))
    Played(
        [Asker("dead", (0, pair(b"d"))), other],
        lambda asked, now_ns: after(MS, next(said))(asked, now_ns) if asked == b"o" else [],
    ).run(1_000 * MS)
    assert [(result.errno, result.data) for result in other.results] == [(EPROTO, b"1234")]


def test_two_late_replies_of_one_are_not_taken_for_a_silent_one_s() -> None:
    """The first one's late reply looks like the second's, whose two replies look like the third's."""
    askers = [Asker(name, (at * MS, pair(name.encode()))) for name, at in (("a", 0), ("b", 33), ("c", 70))]
    coming = [(36 * MS, b"aa"), (75 * MS, b"bb"), (82 * MS, b"bb")]
    line = Played(askers, coming=coming)
    line.run(1_000 * MS)
    assert [item for _, item in line.sent] == [b"a", b"b", b"b", b"c", b"c", b"c"]
    assert [asker.results[0].errno for asker in askers] == [ETIMEDOUT] * 3


def test_a_framed_reply_is_asked_for_once() -> None:
    other = Asker("other", (100 * MS, framed(b"o", 2)))
    line = Played([Asker("dead", (0, pair(b"d"))), other], only(b"o"))
    line.run(1_000 * MS)
    assert sum(item == b"o" for _, item in line.sent) == 1


@given(data(), lists(lists(integers(0, 2_000), min_size=1, max_size=8), min_size=2, max_size=5))
def test_a_reply_that_comes_too_late_is_never_taken_for_another_s(
    play: DataObject, times: list[list[int]]
) -> None:
    askers = [
        Asker(str(number), *((at * MS, pair(bytes((number,)))) for at in sorted(each)))
        for number, each in enumerate(times)
    ]

    def answers(request: bytes, now_ns: int) -> list[tuple[int, bytes]]:
        delay_ms = play.draw(sampled_from([1, 1, 1, 25, 40, 80, 150, 250, 290, None]))
        return [] if delay_ms is None else after(delay_ms * MS + REPLY_NS, request * 2)(request, now_ns)

    Played(askers, answers).run(60_000 * MS)
    for number, (asker, each) in enumerate(zip(askers, times, strict=True)):
        assert len(asker.results) == len(each)
        assert {result.data for result in asker.results if not result.errno} <= {bytes((number, number))}


@composite
def transfers(draw: Callable[..., Any]) -> SerialTransfer:
    send = draw(lists(binary(min_size=1, max_size=4), min_size=1, max_size=2))
    if draw(booleans()):
        send.insert(0, Break(0.002))
    length = draw(sampled_from([None, exactly(1), exactly(2), exactly(5), len_of_first, never_known]))
    within_ns = draw(integers(0, 30)) * MS
    return SerialTransfer(
        tuple(send), length, within_ns, draw(booleans()), draw(booleans()), draw(sampled_from([0, 4 * MS]))
    )


def len_of_first(heard: bytes) -> int:
    return heard[0] % 8


def never_known(heard: bytes) -> int:
    return 0


@given(
    lists(lists(tuples(integers(0, 400), transfers()), min_size=1, max_size=5), min_size=1, max_size=4),
    lists(tuples(integers(0, 600), binary(min_size=1, max_size=6)), max_size=60),
    lists(integers(0, 50), max_size=20),
)
def test_whatever_comes_in_every_transfer_has_one_result_in_time_and_only_one_is_under_way(
    wishes: list[list[tuple[int, SerialTransfer]]], coming: list[tuple[int, bytes]], stalls: list[int]
) -> None:
    askers = [Asker(str(n), *((at * MS, t) for at, t in each)) for n, each in enumerate(wishes)]
    line = Played(askers, coming=[(at * MS, chunk) for at, chunk in coming])
    delays = iter(stalls)
    line.stall_ns = lambda: next(delays, 0) * MS
    line.run(60_000 * MS)
    spans = []
    for asker, each in zip(askers, wishes, strict=True):
        assert [result.transfer for result in asker.results] == [transfer for _, transfer in each]
        for result, end_ns in zip(asker.results, asker.ends_ns, strict=True):
            spans.append((result.start_ns, end_ns))
            longest = longest_ns(result.transfer, BYTE_NS) + sum(stalls) * MS
            assert duration_ns(result.transfer, BYTE_NS) <= end_ns - result.start_ns <= longest
    assert all(first[1] <= second[0] for first, second in pairwise(sorted(spans)))
    assert line.line.step(line.now_ns, []).deadline_ns == NEVER_NS
