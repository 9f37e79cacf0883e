from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

from hypothesis import given
from hypothesis.strategies import binary, lists, none, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.conversation import Conversation
from echogrid.drivers.device import State
from echogrid.drivers.ff_on_demand import FfOnDemand
from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.drivers.role import RangerRole, Slot

MS = 1_000_000
SECOND = 1000 * MS
SPEED = 343.0
SLOT = Slot(200 * MS, 30 * MS)
ROLE = RangerRole("front", 0.25, 4.0, SLOT, SPEED)
FAR = bytes.fromhex("FF07A1A7")
NOTHING = bytes.fromhex("FF0000FF")
BYTE_NS = 11 * SECOND // 9600


class Bench:
    """A ranger played by hand, which says `reply` 50 ms after its trigger."""

    def __init__(self, role: RangerRole = ROLE, **settings: Any) -> None:
        self.device = FfOnDemand(role, FfOnDemand.Settings(**settings))
        self.line = Conversation("line", [self.device])
        self.now_ns = 0
        self.reply: bytes | None = FAR
        self.after_ns = 50 * MS
        self.triggers: list[tuple[int, bytes]] = []
        self.readings: list[RangeReading] = []
        self._coming: list[tuple[int, bytes]] = []

    def run(self, for_ns: int, look: Callable[[], None] = lambda: None) -> list[RangeReading]:
        """The readings of so much time."""
        end_ns, before = self.now_ns + for_ns, len(self.readings)
        due_ns = self.now_ns
        while due_ns <= end_ns:
            self.now_ns = due_ns
            received = [data for time_ns, data in self._coming if time_ns <= due_ns]
            self._coming = [each for each in self._coming if each[0] > due_ns]
            step = self.line.step(due_ns, received)
            self.readings += [reading for reading in step.readings if isinstance(reading, RangeReading)]
            for item in step.send:
                assert isinstance(item, bytes)
                self.triggers.append((due_ns, item))
                if self.reply is not None:
                    self._coming.append((due_ns + self.after_ns, self.reply))
            look()
            due_ns = min([step.deadline_ns, *(time_ns for time_ns, _ in self._coming)])
        self.now_ns = end_ns
        return self.readings[before:]

    @property
    def state(self) -> State:
        return self.device.health(self.now_ns).state


def test_it_is_set_up_with_a_ping_in_a_turn_of_its_own() -> None:
    bench = Bench()
    assert bench.state is State.SETTING_UP
    assert bench.run(100 * MS) == []
    assert bench.triggers == [(30 * MS, b"\x55")]


def test_it_pings_in_its_turns_and_each_gives_one_reading() -> None:
    bench = Bench()
    readings = bench.run(1000 * MS)
    assert [time_ns for time_ns, _ in bench.triggers] == [30 * MS + n * 200 * MS for n in range(5)]
    assert [reading.distance for reading in readings] == [1.953] * 4
    assert bench.state is State.WELL


def test_the_stamp_is_when_the_sound_met_the_obstacle() -> None:
    (reading,) = Bench().run(400 * MS)
    assert reading.stamp_ns == 230 * MS + BYTE_NS + round(1.953 / SPEED * 1e9)
    assert reading.stamp_error_ns == BYTE_NS
    assert reading.raw == FAR


@mark.parametrize(
    ("settings", "trigger"),
    [({}, b"\x55"), ({"part": "aj-sr04m"}, b"\x01"), ({"part": "aj-sr04m", "trigger": 0x55}, b"\x55")],
)
def test_the_trigger_is_the_parts_unless_the_user_says_otherwise(
    settings: dict[str, Any], trigger: bytes
) -> None:
    bench = Bench(**settings)
    bench.run(100 * MS)
    assert [data for _, data in bench.triggers] == [trigger]


@mark.parametrize(
    ("reply", "outcome"),
    [
        (FAR, Outcome.ECHO),
        (NOTHING, Outcome.NO_ECHO),
        (bytes.fromhex("FFFFFDFB"), Outcome.NO_ECHO),
        (bytes.fromhex("FFFFFEFC"), Outcome.INVALID),
        (bytes.fromhex("FF00E0DF"), Outcome.TOO_CLOSE),
        (bytes.fromhex("FF1194A4"), Outcome.NO_ECHO),
    ],
)
def test_the_known_frames_have_their_meaning(reply: bytes, outcome: Outcome) -> None:
    bench = Bench()
    bench.reply = reply
    readings = bench.run(800 * MS)
    assert {(reading.outcome, reading.raw) for reading in readings} == {(outcome, reply)}
    assert bench.state is (State.FAULTY if outcome is Outcome.INVALID else State.WELL)


def test_a_board_that_leaves_the_header_out_of_the_sum_is_told_so() -> None:
    bench = Bench(header_summed=False)
    bench.reply = bytes.fromhex("FF02DEE0")
    assert {reading.distance for reading in bench.run(800 * MS)} == {0.734}


def test_without_a_reply_it_is_missing_and_asked_ever_less_often() -> None:
    bench = Bench()
    bench.reply = None
    assert bench.run(10 * SECOND) == []
    assert bench.state is State.MISSING
    assert "no reply from the ranger: check its power, wires" in bench.device.health(bench.now_ns).message
    assert 5 <= len(bench.triggers) <= 10


def test_a_ranger_that_falls_silent_is_missing_and_comes_back() -> None:
    bench = Bench()
    bench.run(1000 * MS)
    bench.reply = None
    assert bench.run(1000 * MS) == []
    assert bench.state is State.MISSING
    bench.reply = FAR
    assert {reading.distance for reading in bench.run(3000 * MS)} == {1.953}
    assert bench.state is State.WELL


def test_where_silence_means_no_echo_it_does_so_for_a_while_only() -> None:
    bench = Bench(silent_s=1.2)
    bench.run(1000 * MS)
    bench.reply = None
    silent = bench.run(1000 * MS)
    assert {reading.outcome for reading in silent} == {Outcome.NO_ECHO}
    assert len(silent) == 5
    assert {reading.raw for reading in silent} == {b""}
    assert bench.state is State.WELL
    assert bench.run(2000 * MS) == []
    assert bench.state is State.MISSING


def test_where_silence_means_no_echo_a_ranger_that_never_spoke_is_missing_all_the_same() -> None:
    bench = Bench(silent_s=3600.0)
    bench.reply = None
    assert bench.run(3000 * MS) == []
    assert bench.state is State.MISSING


def test_noise_instead_of_frames_is_told_as_such() -> None:
    bench = Bench()
    bench.run(1000 * MS)
    bench.reply = b"abcd"
    (reading,) = bench.run(1000 * MS)
    assert (reading.outcome, reading.raw) == (Outcome.INVALID, b"abcd")
    assert bench.state is State.GARBLED
    assert "does it send at 9600 baud" in bench.device.health(bench.now_ns).message
    bench.reply = FAR
    bench.run(3000 * MS)
    assert bench.state is State.WELL


@mark.parametrize("reply", [FAR[:3], FAR + b"\x00"])
def test_replies_of_another_length_are_told_as_such(reply: bytes) -> None:
    bench = Bench()
    bench.run(1000 * MS)
    bench.reply = reply
    bench.run(2000 * MS)
    assert bench.state is State.GARBLED


def test_a_late_frame_is_not_taken_for_the_next_ping() -> None:
    bench = Bench()
    bench.run(1000 * MS)
    bench.after_ns = 150 * MS
    assert bench.run(1000 * MS) == []
    assert bench.line.stray_bytes > 0


def test_a_ping_under_way_when_the_port_is_lost_is_set_up_anew() -> None:
    bench = Bench()
    bench.run(250 * MS)
    bench.line.lost(bench.now_ns)
    assert len(bench.run(1000 * MS)) == 3


def test_it_never_pings_again_within_60_ms() -> None:
    bench = Bench(replace(ROLE, slot=Slot(20 * MS, 0)))
    bench.after_ns = 5 * MS
    bench.run(1000 * MS)
    times = [time_ns for time_ns, _ in bench.triggers]
    assert min(after - before for before, after in pairwise(times)) >= 60 * MS


def test_without_a_slot_it_pings_as_often_as_it_may() -> None:
    bench = Bench(replace(ROLE, slot=None))
    assert 6 <= len(bench.run(1000 * MS)) <= 8


def test_more_than_the_part_reaches_is_refused() -> None:
    with raises(ValueError, match=r"max_m is 7\.0: expected 0\.0 to 6\.0"):
        Bench(replace(ROLE, farthest=7.0))


@mark.parametrize(
    "wrong", [{"trigger": 256}, {"wait_ms": 0}, {"silent_s": -1}, {"reach_m": 11.0}, {"baud": 1}]
)
def test_impossible_settings_are_refused_by_name(wrong: dict[str, Any]) -> None:
    with raises(ValueError, match=f"{next(iter(wrong))} is .*: expected"):
        FfOnDemand.Settings(**wrong)


@given(lists(none() | binary(max_size=9) | sampled_from([FAR, NOTHING]), max_size=20))
def test_whatever_it_says_readings_are_possible_and_it_comes_back(replies: list[bytes | None]) -> None:
    bench = Bench()
    for reply in replies:
        bench.reply = reply
        bench.run(200 * MS)
    bench.reply = FAR
    bench.run(4000 * MS)
    for reading in bench.readings:
        assert (reading.outcome is Outcome.ECHO) == (ROLE.nearest <= reading.distance < ROLE.farthest)
    assert bench.readings[-1].distance == approx(1.953)
    assert bench.state is State.WELL
