"""A ranger which pings when it is told to: set up, wait for the turn, fire, wait for the answer, report."""

from collections import Counter
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import replace
from math import nan
from typing import Generic

from echogrid.drivers.bus import Result, Transfer
from echogrid.drivers.course import Course, Pilot
from echogrid.drivers.device import Health, State, Step
from echogrid.drivers.make import MILLISECOND_NS, Answer, Fired, Make, Trouble
from echogrid.drivers.pace import Pace, pace_of
from echogrid.drivers.readings import Outcome, RangeReading, classify
from echogrid.drivers.role import Call, RangerRole, Slot, Turn

POLL_NS = 5 * MILLISECOND_NS
LATEST_NS = 10 * MILLISECOND_NS
"""A turn which is missed by more is left to the neighbours."""
FIRST_BACK_OFF_NS = 100 * MILLISECOND_NS
LONGEST_BACK_OFF_NS = 2_000 * MILLISECOND_NS
STALLED_NS = 500 * MILLISECOND_NS


class CommandedRanger(Generic[Transfer]):
    """Takes one ranger through its turns. Every ping gives exactly one reading."""

    def __init__(self, role: RangerRole, make: Make[Transfer]) -> None:
        """Raises ValueError if it is to be fired in a way that its make does not know."""
        if role.call is not Call.ITSELF and not make.obeys_general_call:
            raise ValueError(f"{role.name} obeys no general call: let it fire by itself")
        self.name = role.name
        self._role = role
        self._make = make
        self._slot = role.slot or Slot(make.ping_ns + make.rest_ns, 0)
        self._counts: Counter[str] = Counter()
        self._fired_ns = -make.rest_ns
        self._ping: Fired | None = None
        self._called: Fired | None = None
        self._listens = False
        self._present = False
        self._set_up_ns = 0
        self._turn: Turn | None = None
        """The last one that was waited for since the set-up."""
        self._trouble = Trouble(State.SETTING_UP, "not set up yet")
        self._doubted = State.FAULTY
        self._latest: RangeReading | None = None
        self._readings: list[RangeReading] = []
        self._pilot = Pilot(make.idle)
        self._pilot.start(self._live(), 0)

    def step(self, now_ns: int, received: Sequence[Result[Transfer]]) -> Step[Transfer]:
        """Take the results of own transfers and say what comes next."""
        if self._role.call is Call.CALLED:
            self._overhear(now_ns, received)
        send = self._pilot.step(now_ns, received)
        readings = tuple(self._readings)
        self._readings.clear()
        for reading in readings:
            self._counts["listened" if reading.listened else reading.outcome.value] += 1
        return Step(readings, send, self._pilot.deadline_ns)

    def lost(self, now_ns: int) -> None:
        """The port was lost: the ping under way is void, and the device may have lost its set-up with it."""
        if self._ping is not None:
            self._report(self._stamped(self._ping, Outcome.INVALID, self._role.farthest, "port lost"))
            self._doubted = State.FAULTY
        self._trouble = Trouble(State.SETTING_UP, "not set up again yet")
        self._present = False
        self._pilot.start(self._live(), now_ns)

    def health(self, now_ns: int) -> Health:
        """How it is."""
        counts = dict(self._counts)
        if self._pilot.unanswered:
            counts["unanswered transfers"] = self._pilot.unanswered
        trouble = self._condition(now_ns)
        return Health(trouble.state, trouble.message, counts)

    @property
    def can_listen(self) -> bool:
        """Whether it can do all but ping."""
        return self._make.can_listen

    @property
    def obeys_general_call(self) -> bool:
        """Whether one of its kind can fire all of them on the bus."""
        return self._make.obeys_general_call

    def pace(self, bit_rate: int) -> Pace:
        """How quick it is, on a bus of so many bit/s: that is rehearsed with a copy of its make."""
        return pace_of(deepcopy(self._make), bit_rate)

    def _condition(self, now_ns: int) -> Trouble:
        if not self._present:
            return self._trouble
        latest_ns = self._latest.stamp_ns if self._latest else 0
        if now_ns - max(latest_ns, self._set_up_ns) > 3 * self._slot.period_ns + STALLED_NS:
            what = f"no reading from {self._make.where} for a while: is its bus held up?"
            return Trouble(State.STALLED, what)
        if self._latest is None or latest_ns < self._set_up_ns:
            return self._trouble  # It lasts until a reading shows that it is over.
        if self._latest.outcome is Outcome.INVALID:
            return Trouble(self._doubted, f"invalid reading: {self._latest.reason}")
        return Trouble(State.WELL, "ranging")

    def _overhear(self, now_ns: int, received: Sequence[Result[Transfer]]) -> None:
        """See whether another one's general call has fired this ranger."""
        for result in received:
            if self._present and self._ping is None and (fired := self._make.called(result)):
                self._called = fired
                self._pilot.now_ns = now_ns
                self._pilot.wake()

    def _live(self) -> Course[Transfer, None]:
        while True:
            yield from self._set_up()
            while self._present:
                yield from self._take_turn()

    def _set_up(self) -> Course[Transfer, None]:
        """Come back when the ranger is there and knows its settings."""
        back_off_ns = FIRST_BACK_OFF_NS
        while trouble := (yield from self._make.set_up()):
            self._trouble = trouble
            self._counts[trouble.state.value] += 1
            yield from self._back_off(self._pilot.now_ns + back_off_ns)
            back_off_ns = min(2 * back_off_ns, LONGEST_BACK_OFF_NS)
        self._counts["set-ups"] += 1
        self._set_up_ns, self._turn = self._pilot.now_ns, None
        self._present = True

    def _back_off(self, until_ns: int) -> Course[Transfer, None]:
        """Wait. With general calls: till shortly before one, when those before have ceased to keep it busy;
        and who fires for all goes on doing so, or its silence would be theirs."""
        if self._role.call is Call.ITSELF:
            yield until_ns
            return
        while (turn := self._slot.next_turn(self._pilot.now_ns)).start_ns - LATEST_NS < until_ns:
            yield turn.start_ns
            if self._role.call is Call.ALL and self._pilot.now_ns - turn.start_ns <= LATEST_NS:
                yield from self._make.fire_all()
        yield turn.start_ns - LATEST_NS

    def _take_turn(self) -> Course[Transfer, None]:
        """Wait for the turn, fire, and report what became of it."""
        fired = yield from (self._await_call() if self._role.call is Call.CALLED else self._fire())
        if fired is None:
            return
        self._fired_ns = fired.stamp_ns
        if fired.trouble:
            self._counts["failed to fire"] += 1
            what = f"{self._make.where} did not take the command to fire: {fired.trouble}"
            self._give_up(Trouble(fired.state, what))
            return
        self._ping = fired
        if fired.silent:
            self._report(self._stamped(fired, Outcome.NO_ECHO, self._role.farthest))
            return
        data = fired.data or (yield from self._awaited(fired.stamp_ns + self._make.ping_ns))
        self._report(self._reading(fired, data))

    def _fire(self) -> Course[Transfer, Fired | None]:
        turn = self._slot.next_turn(max(self._pilot.now_ns, self._fired_ns + self._make.rest_ns))
        self._count_passed_over(turn)
        yield turn.start_ns
        if self._pilot.now_ns - turn.start_ns > LATEST_NS:
            self._counts["missed slots"] += 1
            return None
        self._listens = turn.listens
        calls = self._role.call is Call.ALL
        fired = yield from (self._make.fire_all() if calls else self._make.fire(turn.listens))
        if fired.stamp_ns - turn.start_ns > LATEST_NS:
            self._counts["late pings"] += 1
        return fired

    def _count_passed_over(self, turn: Turn) -> None:
        """Count the turns of its own slot that it could not take, being busy or at rest."""
        if self._turn is not None and self._role.slot is not None:
            self._counts["missed slots"] += turn.number - self._turn.number - 1
        self._turn = turn

    def _await_call(self) -> Course[Transfer, Fired | None]:
        """Wait until another one fires for all, or for so long that it must have forgotten to."""
        turn: Turn = self._slot.next_turn(self._pilot.now_ns)
        self._called = None
        yield turn.start_ns + self._slot.period_ns + LATEST_NS
        if self._called is None:
            self._counts["missed slots"] += 1
        return self._called

    def _awaited(self, expected_ns: int) -> Course[Transfer, bytes]:
        """The answer when the ping is over, or nothing if that takes too long."""
        yield from self._make.meanwhile()
        yield expected_ns
        while not (data := (yield from self._make.collect())):
            self._counts["busy"] += 1
            if self._pilot.now_ns + POLL_NS > expected_ns + self._make.patience_ns:
                return b""
            yield self._pilot.now_ns + POLL_NS
        return data

    def _reading(self, ping: Fired, data: bytes) -> RangeReading:
        """An answer that cannot be may mean that it is gone, or forgot its settings: it is set up again."""
        answer = self._make.answer(data) if data else Answer(doubt="not ready in time", state=State.MISSING)
        if answer.doubt:
            self._doubted = answer.state
            if answer.gone:
                self._give_up(Trouble(answer.state, f"{self._make.where}: {answer.doubt}"))
            return self._stamped(ping, Outcome.INVALID, self._role.farthest, answer.doubt, data)
        if not answer.distances:
            return self._stamped(ping, Outcome.NO_ECHO, self._role.farthest, raw=data)
        measured, *later = answer.distances
        nearest = max(self._role.nearest, answer.nearest)
        outcome, _ = classify(measured, nearest, self._role.farthest)
        reading = self._stamped(ping, outcome, min(measured, self._role.farthest), raw=data)
        if outcome is not Outcome.ECHO:
            return reading
        return replace(reading, later=tuple(each for each in later if each < self._role.farthest))

    def _give_up(self, trouble: Trouble) -> None:
        self._trouble = trouble  # First: another thread may look at it as soon as it is not present.
        self._present = False

    def _stamped(
        self, ping: Fired, outcome: Outcome, reached: float, reason: str = "", raw: bytes = b""
    ) -> RangeReading:
        """The reading whose sound had gone `reached` metres at the moment that counts."""
        stamp_ns = ping.stamp_ns + round(reached / self._role.speed_of_sound * 1e9)
        distance = reached if outcome is Outcome.ECHO else nan
        return RangeReading(
            stamp_ns, ping.error_ns, self.name, outcome, distance, raw, reason, listened=self._listens
        )

    def _report(self, reading: RangeReading) -> None:
        self._latest = reading
        self._readings.append(reading)
        self._ping = None
