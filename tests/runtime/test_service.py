import json
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers.device import Health, State
from echogrid.drivers.readings import RangeReading, Reading
from echogrid.mapping.reckoning import YawRate
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime.acquisition import DeviceReport
from echogrid.runtime.loop import FixedRateLoop
from echogrid.runtime.service import Run
from echogrid.runtime.status import Status

from .fakes import MS, SECOND, HandClock, echo
from .test_fusion import drive, fusion

REPORTS = [DeviceReport("front", "line", Health(State.FAULTY, "hoarse", {"echo": 3, "a": 1}))]


class Supply:
    """Gives each reading at the first drain after its stamp, and the last ones only when stopped."""

    def __init__(self, clock: HandClock, readings: list[Reading], most: int = 1000) -> None:
        self.clock = clock
        self.readings = sorted(readings, key=lambda reading: reading.stamp_ns)
        self.most = most
        self.overflow: list[Reading] = []
        self.stopped = 0

    def drain(self) -> list[Reading]:
        due = [r for r in self.readings if self.stopped or r.stamp_ns <= self.clock.time_ns - 100 * MS]
        self.readings = self.readings[len(due) :]
        self.overflow += due[: -self.most]
        return due[-self.most :]

    def drain_overflow(self) -> list[Reading]:
        overflow, self.overflow = self.overflow, []
        return overflow

    def report(self, now_ns: int) -> list[DeviceReport]:
        return REPORTS

    def stop(self) -> None:
        self.stopped += 1


class Tape:
    def __init__(self) -> None:
        self.ranges: list[RangeReading] = []
        self.wheels: list[WheelAngles] = []

    def put(
        self, ranges: tuple[RangeReading, ...], wheels: tuple[WheelAngles, ...], _: tuple[YawRate, ...]
    ) -> None:
        self.ranges += ranges
        self.wheels += wheels


def run_with(most: int = 1000) -> tuple[Run, Supply, Tape]:
    clock = HandClock(SECOND)
    readings = [*drive(), *(echo(SECOND + k * 50 * MS) for k in range(60))]
    supply, tape = Supply(clock, readings, most), Tape()
    return Run(fusion(), FixedRateLoop(clock, 50.0), supply, clock, (tape,)), supply, tape


def ignore(status: Status) -> None:
    """Show nothing."""


def test_everything_is_taken_in_fused_and_put_on_the_tape() -> None:
    run, supply, tape = run_with()
    run.go(3.0, ignore)
    assert supply.stopped == 1
    assert (run.fusion.ledger.fused, run.fusion.waiting) == (60, 0)
    assert len(tape.ranges) == 60
    assert len(tape.wheels) == 201
    assert run.readings == {"front": 60, "left": 201, "right": 201}
    assert (run.loop.in_time, run.loop.late, run.loop.skipped) == (149, 0, 0)


def test_the_path_has_at_most_ten_poses_a_second() -> None:
    run, _, tape = run_with()
    run.go(4.0, ignore)
    stamps = [stamp_ns for stamp_ns, _ in run.path]
    assert len(stamps) > 20
    assert all(after - before >= 100 * MS for before, after in pairwise(stamps))
    assert set(stamps) <= {angles.stamp_ns for angles in tape.wheels}


def test_it_shows_its_status_each_second() -> None:
    run, _, _ = run_with()
    shown: list[Status] = []
    run.go(4.0, shown.append)
    assert [round(status.elapsed_s, 3) for status in shown] == [1.0, 2.0, 3.0]
    assert [status.tick_rate_hz for status in shown] == [50.0, 50.0, 50.0]
    assert all("1/1" not in status.line() and "front" in status.line() for status in shown)


def test_it_stops_after_the_tick_in_which_it_was_told_to() -> None:
    run, supply, _ = run_with()

    def stop(status: Status) -> None:
        run.stopping = True

    run.go(None, stop)
    assert run.clock.now_ns() == 2 * SECOND
    assert supply.stopped == 1
    assert run.fusion.waiting == 0


@given(st.integers(1, 20))
def test_what_overflowed_is_in_the_books_and_not_on_the_tape(most: int) -> None:
    run, _, tape = run_with(most)
    run.go(2.0, ignore)
    ledger = run.fusion.ledger
    assert ledger.produced == 60
    assert ledger.dropped["queue full"] == 60 - len(tape.ranges)
    assert ledger.balances(0)


def test_the_report_is_json_with_books_ticks_and_devices() -> None:
    run, _, _ = run_with()
    run.go(3.0, ignore)
    report = json.loads(json.dumps(run.report(REPORTS), allow_nan=False))
    assert report["readings"] == report["fused"] == 60
    assert report["balances"] is True
    assert report["ticks"] == {"in_time": 149, "late": 0, "skipped": 0}
    assert report["devices"] == {
        "front": {"level": "WARN", "message": "hoarse", "counts": {"a": 1, "echo": 3}}
    }
