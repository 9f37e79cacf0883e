from collections import Counter
from dataclasses import dataclass, replace
from math import nan
from random import Random

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.long_term_map import LongTermMap
from echogrid.mapping.mapper import REORDER_NS, Mapper
from echogrid.mapping.pose import Pose
from echogrid.mapping.pose_buffer import PoseBuffer
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import Form, NoEcho
from echogrid.mapping.verification import Verifier

MS = 1_000_000
SECOND = 1000 * MS
GEOMETRY = GridGeometry.covering(-3.0, -3.0, 3.0, 3.0, 0.2)
SENSORS = ("front", "left", "right")
RANGERS = tuple(
    Ranger(name, Pose(0.1, 0.0, yaw), 0.26, 0.1, 3.0)
    for name, yaw in zip(SENSORS, (0.0, 0.2, -0.2), strict=True)
)
GAPS_MS = (20, 50, 200, 600)
"""Between poses; nothing is interpolated over the last one."""


class Bench:
    """A mapper, whose every operation leaves the books in balance."""

    def __init__(
        self,
        no_echo: NoEcho = NoEcho.WEAK,
        most_waiting: int | None = 4096,
        verifier: Verifier | None = None,
    ) -> None:
        self.grid = BayesGrid(GEOMETRY, 2.0, Form.CONSISTENT, no_echo)
        map_ = LongTermMap(GEOMETRY, 0.1, lambda _: self.grid)
        self.mapper = Mapper(RANGERS, PoseBuffer(), map_, most_waiting, verifier)
        self.reasons: Counter[str] = Counter()
        self.placed = 0

    def pose(self, stamp_ns: int, pose: Pose | None = None) -> None:
        self.mapper.add_pose(stamp_ns, Pose() if pose is None else pose)
        self._balance()

    def add(self, *readings: RangeReading) -> None:
        for reading in readings:
            self.mapper.add(reading)
            self._balance()

    def advance(self) -> None:
        placed, drops = self.mapper.advance()
        self.placed += len(placed)
        self.reasons.update(drop.reason for drop in drops)
        self._balance()

    def finish(self) -> None:
        self.reasons.update(drop.reason for drop in self.mapper.finish())
        self._balance()
        assert self.mapper.waiting == 0
        assert self.reasons == self.mapper.ledger.dropped

    def _balance(self) -> None:
        assert self.mapper.ledger.balances(self.mapper.waiting)


def reading(
    stamp_ns: int, sensor: str = "front", outcome: Outcome = Outcome.ECHO, distance: float = 1.0
) -> RangeReading:
    return RangeReading(stamp_ns, 0, sensor, outcome, distance if outcome is Outcome.ECHO else nan)


@dataclass
class Log:
    """A drive: poses and readings in order of their stamps."""

    poses: list[tuple[int, Pose]]
    readings: list[RangeReading]


def drive(random: Random) -> Log:
    """Some seconds of it, with gaps in the poses, readings before and after them, and all outcomes."""
    poses, stamp = [], 10 * SECOND
    for _ in range(random.randint(1, 40)):
        poses.append((stamp, Pose(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-3, 3))))
        stamp += random.choice(GAPS_MS) * MS
    span = 10 * SECOND - 300 * MS, stamp + 300 * MS
    keys = {(random.randrange(*span, 100 * MS), random.choice(SENSORS)) for _ in range(60)}
    readings = [
        reading(at, sensor, random.choice([*Outcome, Outcome.ECHO, Outcome.ECHO]), random.uniform(0.1, 3.0))
        for at, sensor in sorted(keys)
    ]
    return Log(poses, readings)


def arrival(log: Log, random: Random) -> list[RangeReading | tuple[int, Pose]]:
    """Readings up to the reorder window out of order, poses in theirs but at any time between."""
    readings = sorted(log.readings, key=lambda each: each.stamp_ns + random.uniform(0, REORDER_NS))
    turns = [True] * len(log.poses) + [False] * len(readings)
    random.shuffle(turns)
    poses, others = iter(log.poses), iter(readings)
    return [next(poses) if turn else next(others) for turn in turns]


@settings(deadline=None)
@given(st.randoms(use_true_random=False), st.floats(0.0, 1.0), st.booleans())
def test_the_map_and_the_books_depend_on_readings_and_poses_alone(
    random: Random, advancing: float, verified: bool
) -> None:
    log = drive(random)
    whole, cut = (Bench(verifier=Verifier(0.5) if verified else None) for _ in range(2))
    for stamp_ns, pose in log.poses:
        whole.pose(stamp_ns, pose)
    whole.add(*log.readings)
    whole.finish()
    for event in arrival(log, random):
        if isinstance(event, RangeReading):
            cut.add(event)
        else:
            cut.pose(*event)
        if random.random() < advancing:
            cut.advance()
    cut.finish()
    assert np.array_equal(whole.grid.log_odds, cut.grid.log_odds)
    assert np.array_equal(whole.grid.unknown(), cut.grid.unknown())
    assert whole.mapper.ledger == cut.mapper.ledger


def test_the_order_of_arrival_would_matter_at_the_clamp_but_for_the_mapper() -> None:
    """Ten echoes at 1 m, then one from beyond: in the other order the cell would end elsewhere."""
    near = [reading(n * MS, distance=1.0) for n in range(10)]
    far = reading(20 * MS, distance=2.0)
    ends = []
    for order in ([*near, far], [far, *near]):
        bench = Bench()
        bench.pose(0)
        bench.pose(100 * MS)
        bench.add(*order)
        bench.finish()
        ends.append(bench.grid.log_odds.copy())
    assert np.array_equal(*ends)


def test_a_reading_waits_for_a_pose_that_is_later() -> None:
    bench = Bench()
    bench.pose(0)
    bench.add(reading(50 * MS))
    bench.advance()
    assert (bench.placed, bench.mapper.waiting) == (0, 1)
    bench.pose(100 * MS)
    bench.advance()
    assert (bench.placed, bench.mapper.waiting) == (1, 1)


def test_a_placed_reading_waits_until_no_earlier_one_may_come() -> None:
    bench = Bench()
    for stamp in range(0, 3000, 100):
        bench.pose(stamp * MS)
    bench.add(reading(0), reading(REORDER_NS))
    bench.advance()
    assert bench.mapper.ledger.fused == 0
    bench.add(reading(REORDER_NS + 1))
    bench.advance()
    assert bench.mapper.ledger.fused == 1


def test_a_ping_is_placed_where_the_robot_was_and_its_sensor_sits() -> None:
    bench = Bench()
    bench.pose(0, Pose())
    bench.pose(100 * MS, Pose(1.0, 0.0, 0.0))
    bench.add(reading(50 * MS, "left"))
    (ping,), _ = bench.mapper.advance()
    assert ping.transducer == Pose(0.6, 0.0, 0.2)
    assert ping.ranger is RANGERS[1]


def test_a_reading_older_than_the_window_is_late() -> None:
    bench = Bench()
    bench.pose(0)
    bench.pose(100 * MS)
    bench.add(reading(5 * SECOND), reading(5 * SECOND - REORDER_NS), reading(5 * SECOND - REORDER_NS - 1))
    bench.advance()
    assert bench.reasons == {"late": 1}


def test_a_reading_of_an_unknown_sensor_is_dropped_and_makes_no_other_late() -> None:
    bench = Bench()
    bench.pose(0)
    bench.pose(100 * MS)
    bench.add(reading(3600 * SECOND, "nobody"), reading(50 * MS))
    bench.finish()
    assert bench.reasons == {"unknown sensor": 1}
    assert bench.mapper.ledger.fused == 1


def test_readings_outside_the_poses_span_are_dropped() -> None:
    bench = Bench()
    bench.pose(100 * MS)
    bench.pose(200 * MS)
    bench.add(reading(99 * MS), reading(150 * MS), reading(201 * MS))
    bench.finish()
    assert bench.reasons == {"outside the pose span": 2}


def test_a_reading_in_a_gap_of_the_poses_is_dropped() -> None:
    bench = Bench()
    bench.pose(0)
    bench.pose(600 * MS)
    bench.add(reading(300 * MS))
    bench.advance()
    assert bench.reasons == {"pose gap": 1}


def test_a_reading_outside_the_map_is_dropped() -> None:
    bench = Bench()
    bench.pose(0, Pose(50.0, 0.0))
    bench.pose(100 * MS, Pose(50.0, 0.0))
    bench.add(reading(50 * MS))
    bench.finish()
    assert bench.reasons == {"outside the map": 1}


def test_what_is_not_for_the_map_is_dropped_by_its_outcome() -> None:
    bench = Bench(NoEcho.IGNORE)
    bench.pose(0)
    bench.pose(100 * MS)
    bench.add(*(reading((n + 1) * MS, outcome=outcome) for n, outcome in enumerate(Outcome)))
    bench.finish()
    assert bench.reasons == {"no echo": 1, "too close": 1, "invalid": 1}
    assert bench.mapper.ledger.fused == 1


def test_no_more_than_so_many_wait_for_poses_that_do_not_come() -> None:
    bench = Bench(most_waiting=2)
    bench.add(*(reading(n * MS) for n in range(5)))
    bench.advance()
    assert bench.reasons == {"no pose came": 3}
    assert bench.mapper.waiting == 2


def test_a_refused_reading_is_in_the_books_and_nowhere_else() -> None:
    bench = Bench()
    bench.mapper.refuse(reading(3600 * SECOND), "queue full")
    bench.pose(0)
    bench.add(reading(0))
    bench.finish()
    assert bench.reasons == {"queue full": 1}
    assert bench.mapper.ledger.fused == 1


def test_what_no_other_reading_agrees_with_is_dropped_as_unverified() -> None:
    bench = Bench(verifier=Verifier())
    bench.pose(0)
    bench.pose(500 * MS)
    bench.add(*(reading(n * 100 * MS, distance=r) for n, r in enumerate((1.0, 1.05, 2.0, 1.0))))
    bench.finish()
    assert bench.mapper.ledger.fused == 2
    assert bench.reasons == {"unverified": 2}


def test_a_reading_that_waits_for_the_next_of_its_sensor_is_waiting_in_the_books() -> None:
    bench = Bench(verifier=Verifier())
    for stamp in range(0, 4000, 100):
        bench.pose(stamp * MS)
    bench.add(reading(0), reading(3 * SECOND, "left", Outcome.NO_ECHO))
    bench.advance()
    assert (bench.mapper.ledger.fused, bench.mapper.waiting) == (0, 2)


def test_a_turn_that_only_listened_is_counted_and_not_placed() -> None:
    bench = Bench()
    bench.pose(0)
    bench.pose(100 * MS)
    bench.add(replace(reading(50 * MS), listened=True))
    bench.advance()
    assert (bench.placed, bench.reasons) == (0, {"listened": 1})
