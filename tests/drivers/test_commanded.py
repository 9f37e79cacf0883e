from collections.abc import Sequence
from dataclasses import replace
from errno import ENXIO
from itertools import pairwise

from hypothesis import given
from hypothesis.strategies import booleans, floats, integers, lists, sampled_from, tuples
from pytest import approx, mark, raises

from echogrid.drivers.bus import NEVER_NS, I2cMessage, I2cResult, I2cTransfer, Result
from echogrid.drivers.commanded import LATEST_NS, CommandedRanger
from echogrid.drivers.course import Course
from echogrid.drivers.device import State
from echogrid.drivers.make import Answer, Fired, Make, Trouble
from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.drivers.role import Call, RangerRole, Slot

MS = 1_000_000
SPEED = 343.0
SLOT = Slot(100 * MS, 10 * MS)
ROLE = RangerRole("front", 0.1, 3.0, SLOT, SPEED)
SET_UP, FIRE, LISTEN, ALL, COLLECT = (I2cTransfer((I2cMessage(1, bytes((code,))),)) for code in range(5))


class Maker(Make[I2cTransfer]):
    """A make whose answers are centimetres, one byte each; 0xFF is doubtful."""

    can_listen = obeys_general_call = True

    where = "here"
    idle = I2cTransfer(())
    ping_ns = 20 * MS
    patience_ns = 20 * MS
    rest_ns = 30 * MS

    def set_up(self) -> Course[I2cTransfer, Trouble | None]:
        result = yield SET_UP
        return Trouble(State.MISSING, "not here: look for it") if result.errno else None

    def fire(self, listens: bool) -> Course[I2cTransfer, Fired]:
        result = yield LISTEN if listens else FIRE
        return Fired(result.end_ns, 1, "no acknowledge" if result.errno else "")

    def fire_all(self) -> Course[I2cTransfer, Fired]:
        result = yield ALL
        return Fired(result.end_ns, 1, "no acknowledge" if result.errno else "")

    def called(self, result: Result[I2cTransfer]) -> Fired | None:
        return Fired(result.end_ns, 1) if result.transfer is ALL else None

    def collect(self) -> Course[I2cTransfer, bytes]:
        return (yield COLLECT).data

    def answer(self, data: bytes) -> Answer:
        if data == b"\xff":
            return Answer(doubt="never", state=State.WRONG_DEVICE)
        return Answer(tuple(each / 100 for each in data.rstrip(b"\0")))


class Play:
    """Answers a ranger's transfers, each a millisecond later."""

    def __init__(self, role: RangerRole = ROLE) -> None:
        self.device = CommandedRanger(role, Maker())
        self.now_ns = 0
        self.errno = 0
        self.data = b"\x64"
        self.sent: list[tuple[int, I2cTransfer]] = []
        self.readings: list[RangeReading] = []

    def run(self, for_ns: int, overheard: Sequence[Result[I2cTransfer]] = ()) -> None:
        end_ns = self.now_ns + for_ns
        received = list(overheard)
        while True:
            step = self.device.step(self.now_ns, received)
            self.readings += [each for each in step.readings if isinstance(each, RangeReading)]
            self.sent += [(self.now_ns, transfer) for transfer in step.send]
            received = [self.result(transfer) for transfer in step.send]
            if not received:
                if step.deadline_ns > end_ns:
                    break
                self.now_ns = max(self.now_ns, step.deadline_ns)
        self.now_ns = end_ns

    def result(self, transfer: I2cTransfer) -> Result[I2cTransfer]:
        self.now_ns += MS
        data = self.data if transfer is COLLECT and not self.errno else b""
        return I2cResult(transfer, self.now_ns - MS, self.now_ns, data, self.errno)

    def times(self, transfer: I2cTransfer) -> list[int]:
        return [sent_ns for sent_ns, each in self.sent if each is transfer]

    @property
    def state(self) -> State:
        return self.device.health(self.now_ns).state


def test_every_ping_gives_one_reading_stamped_when_its_sound_met_the_obstacle() -> None:
    play = Play()
    play.run(1000 * MS)
    assert play.times(FIRE) == [10 * MS + turn * 100 * MS for turn in range(10)]
    assert len(play.readings) == 10
    assert {reading.distance for reading in play.readings} == {1.0}
    assert play.readings[0].stamp_ns == 11 * MS + round(1.0 / SPEED * 1e9)
    assert play.state is State.WELL


@given(
    lists(
        tuples(
            integers(1, 300), booleans(), sampled_from([b"", b"\x64", b"\x00", b"\xff", b"\x01", b"\xfe"])
        ),
        max_size=30,
    )
)
def test_whatever_happens_no_ping_gives_two_readings_and_every_echo_is_within_the_limits(
    spells: list[tuple[int, bool, bytes]],
) -> None:
    play = Play()
    for for_ms, acknowledges, data in spells:
        play.errno, play.data = 0 if acknowledges else ENXIO, data
        play.run(for_ms * MS)
    play.errno = ENXIO
    play.run(400 * MS)
    assert len(play.readings) <= len(play.times(FIRE))
    assert all(b.stamp_ns > a.stamp_ns for a, b in pairwise(play.readings))
    for reading in play.readings:
        assert (reading.outcome is Outcome.ECHO) == (ROLE.nearest <= reading.distance < ROLE.farthest)


def test_a_ranger_that_is_missing_says_so_with_what_to_do_and_recovers_by_itself() -> None:
    play = Play()
    play.errno = ENXIO
    play.run(1000 * MS)
    health = play.device.health(play.now_ns)
    assert (health.state, health.message) == (State.MISSING, "not here: look for it")
    assert 3 <= health.counts["missing"] <= 6
    play.errno = 0
    play.run(2200 * MS)
    assert play.state is State.WELL


def test_a_doubtful_answer_is_invalid_and_names_its_state_until_the_next_set_up() -> None:
    play = Play()
    play.run(20 * MS)
    play.data = b"\xff"
    play.errno = 0
    play.run(13 * MS)
    assert [(each.outcome, each.reason) for each in play.readings] == [(Outcome.INVALID, "never")]
    assert len(play.times(SET_UP)) == 2


def test_an_answer_below_the_ranger_s_own_nearest_is_too_close() -> None:
    class NearSighted(Maker):
        def answer(self, data: bytes) -> Answer:
            return replace(super().answer(data), nearest=1.2)

    play = Play()
    play.device = CommandedRanger(ROLE, NearSighted())
    play.run(100 * MS)
    assert [each.outcome for each in play.readings] == [Outcome.TOO_CLOSE]


def test_later_echoes_are_told_in_their_order_as_far_as_the_reach() -> None:
    play = Play(replace(ROLE, farthest=2.0))
    play.data = bytes((100, 150, 199, 200, 250))
    play.run(100 * MS)
    assert play.readings[0].later == approx((1.5, 1.99))


def test_until_a_reading_shows_that_trouble_is_over_it_lasts() -> None:
    play = Play()
    play.run(5 * MS)
    assert play.state is State.SETTING_UP
    play.run(100 * MS)
    assert play.state is State.WELL
    play.errno = ENXIO
    play.run(1000 * MS)
    play.errno = 0
    seen = set()
    for _ in range(3000):
        play.run(MS)
        seen.add(play.state)
    assert seen == {State.MISSING, State.WELL}


def test_turns_that_are_passed_over_while_it_rests_are_counted() -> None:
    play = Play(replace(ROLE, slot=Slot(20 * MS, 0)))
    play.run(1000 * MS)
    missed = play.device.health(play.now_ns).counts["missed slots"]
    assert len(play.times(FIRE)) + missed == approx(49, abs=1)


def test_a_command_that_its_bus_holds_up_is_a_late_ping() -> None:
    play = Play()
    play.run(9 * MS)
    (fire,) = play.device.step(10 * MS, []).send
    play.device.step(30 * MS, [I2cResult(fire, 29 * MS, 30 * MS)])
    assert play.device.health(30 * MS).counts["late pings"] == 1


def test_a_turn_that_only_listens_is_marked() -> None:
    play = Play(replace(ROLE, slot=replace(SLOT, listens_every=3)))
    play.run(900 * MS)
    assert len(play.times(LISTEN)) == 3
    assert sum(reading.listened for reading in play.readings) == 3
    assert play.device.health(play.now_ns).counts["listened"] == 3


def test_one_fires_for_all_and_those_which_are_called_take_it_for_their_own() -> None:
    caller = Play(replace(ROLE, call=Call.ALL))
    caller.run(100 * MS)
    assert caller.times(ALL) == [10 * MS]
    called = Play(replace(ROLE, call=Call.CALLED))
    called.run(10 * MS)
    called.run(89 * MS, [I2cResult(ALL, 10 * MS, 11 * MS)])
    assert called.times(FIRE) == called.times(ALL) == []
    assert [each.stamp_ns for each in called.readings] == [each.stamp_ns for each in caller.readings]


@mark.parametrize("call", [Call.ALL, Call.CALLED])
def test_one_that_obeys_no_general_call_can_t_be_fired_by_one(call: Call) -> None:
    class Deaf(Maker):
        obeys_general_call = False

    with raises(ValueError, match="front obeys no general call: let it fire by itself"):
        CommandedRanger(replace(ROLE, call=call), Deaf())


def test_nobody_calls_and_the_called_one_counts_it_and_goes_on_waiting() -> None:
    called = Play(replace(ROLE, call=Call.CALLED))
    called.run(1000 * MS)
    assert called.readings == []
    assert called.device.health(called.now_ns).counts["missed slots"] >= 4
    called.run(90 * MS, [I2cResult(ALL, called.now_ns, called.now_ns)])
    assert len(called.readings) == 1


def test_a_slot_that_is_missed_by_much_is_left_out() -> None:
    play = Play()
    play.run(5 * MS)
    play.now_ns += 5 * MS + LATEST_NS + 1
    play.run(50 * MS)
    assert play.times(FIRE) == []
    assert play.device.health(play.now_ns).counts["missed slots"] == 1


def test_a_bus_that_answers_nothing_leaves_the_ranger_stalled_or_missing_and_counts_it() -> None:
    device = CommandedRanger(ROLE, Maker())
    now_ns = 0
    for _ in range(5):
        step = device.step(now_ns, [])
        assert step.deadline_ns < NEVER_NS
        now_ns = step.deadline_ns
    health = device.health(now_ns)
    assert health.counts["unanswered transfers"] >= 2
    assert health.state is State.MISSING


@mark.parametrize("number", range(3))
@given(
    period_ms=integers(20, 500),
    offset_ms=integers(0, 500),
    delays=lists(integers(0, 9), min_size=1, max_size=4),
    after=floats(0, 1e5),
)
def test_turns_come_in_order_and_never_early(
    number: int, period_ms: int, offset_ms: int, delays: list[int], after: float
) -> None:
    slot = Slot(
        period_ms * MS, offset_ms * MS, tuple(each * MS for each in delays), jitter_ns=5 * MS, seed=number
    )
    after_ns = round(after * MS)
    turn = slot.next_turn(after_ns)
    following = slot.next_turn(turn.start_ns)
    assert after_ns < turn.start_ns <= after_ns + 2 * period_ms * MS
    assert turn.start_ns < following.start_ns
    late_ns = (turn.start_ns - offset_ms * MS) % (period_ms * MS)
    assert late_ns <= max(delays) * MS + 5 * MS
    assert slot.next_turn(after_ns) == turn
