"""From stamped readings to the long-term map: each ping fused at the pose which the robot had, in order.

The map depends on the readings and poses alone, not on when or in which portions they arrived: so a live
run and its log give the same bits.
"""

import heapq
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.ledger import Ledger
from echogrid.mapping.long_term_map import LongTermMap
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose
from echogrid.mapping.pose_buffer import PoseBuffer, PoseMiss
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.verification import Believer, Verifier

REORDER_NS = 1_000_000_000
"""Readings may come this much out of order."""


@dataclass(frozen=True, slots=True)
class Drop:
    """A reading which is not fused, and why."""

    reading: RangeReading
    reason: str


class Mapper:
    """Places readings, brings them into the order of their stamps (then of sensor names), fuses them.

    A reading waits until a pose later than its stamp is known and until no earlier reading may come; then
    the verifier takes it, which may let it wait for the next one of its sensor.
    """

    def __init__(
        self,
        rangers: Iterable[Ranger],
        poses: PoseBuffer,
        map_: LongTermMap,
        most_waiting: int | None = 4096,
        verifier: Verifier | Believer | None = None,
    ) -> None:
        self.ledger = Ledger()
        self.map = map_
        self._verifier = verifier or Believer()
        self._rangers = {ranger.name: ranger for ranger in rangers}
        self._poses = poses
        self._most_waiting = most_waiting
        self._unplaced: deque[RangeReading] = deque()
        self._ordered: list[tuple[int, str, int, PlacedPing]] = []
        self._newest_ns = -(1 << 62)
        self._entered = 0
        self._drops: list[Drop] = []

    @property
    def waiting(self) -> int:
        """How many readings are neither fused nor dropped yet."""
        return len(self._unplaced) + len(self._ordered) + self._verifier.waiting

    def add_pose(self, stamp_ns: int, pose: Pose) -> bool:
        """Take the robot's pose in the map frame; False unless it is later than the last."""
        return self._poses.add(stamp_ns, pose)

    def add(self, reading: RangeReading) -> None:
        """Take a reading."""
        self.ledger.produce(reading.outcome)
        if reading.sensor not in self._rangers or reading.listened:
            self._drop(reading, "listened" if reading.listened else "unknown sensor")
            return
        self._newest_ns = max(self._newest_ns, reading.stamp_ns)
        if reading.stamp_ns < self._newest_ns - REORDER_NS:
            self._drop(reading, "late")
        else:
            self._unplaced.append(reading)

    def refuse(self, reading: RangeReading, reason: str) -> None:
        """Enter a reading in the books only to drop it."""
        self.ledger.produce(reading.outcome)
        self._drop(reading, reason)

    def advance(self) -> tuple[list[PlacedPing], list[Drop]]:
        """Place and fuse all whose time has come: what was newly placed, and what was dropped."""
        placed = self._place()
        self._fuse_before(self._newest_ns - REORDER_NS)
        return placed, self._take_drops()

    def finish(self) -> list[Drop]:
        """Fuse all that can be placed; nothing more will come. What was dropped at last."""
        self._place()
        self._fuse_before(1 << 62)
        for ping in self._verifier.finish():
            self._drop(ping.reading, "unverified")
        while self._unplaced:
            self._drop(self._unplaced.popleft(), PoseMiss.BEFORE.value)
        return self._take_drops()

    def _place(self) -> list[PlacedPing]:
        placed: list[PlacedPing] = []
        for _ in range(len(self._unplaced)):
            reading = self._unplaced.popleft()
            pose = self._poses.at(reading.stamp_ns)
            if isinstance(pose, Pose):
                placed.append(self._placed(reading, pose))
            elif pose is PoseMiss.NOT_YET:
                self._unplaced.append(reading)
            else:
                self._drop(reading, pose.value)
        while self._most_waiting is not None and len(self._unplaced) > self._most_waiting:
            self._drop(self._unplaced.popleft(), "no pose came")
        return placed

    def _placed(self, reading: RangeReading, pose: Pose) -> PlacedPing:
        ranger = self._rangers[reading.sensor]
        ping = PlacedPing(reading, ranger, pose.compose(ranger.mount))
        self._entered += 1
        heapq.heappush(self._ordered, (reading.stamp_ns, reading.sensor, self._entered, ping))
        return ping

    def _fuse_before(self, stamp_ns: int) -> None:
        while self._ordered and self._ordered[0][0] < stamp_ns:
            verdict = self._verifier.take(heapq.heappop(self._ordered)[-1])
            for ping in verdict.refused:
                self._drop(ping.reading, "unverified")
            for ping in verdict.verified:
                self._fuse(ping)

    def _fuse(self, ping: PlacedPing) -> None:
        reading = ping.reading
        if reading.outcome in (Outcome.INVALID, Outcome.TOO_CLOSE):
            self._drop(reading, reading.outcome.value)
            return
        distance = reading.distance if reading.outcome is Outcome.ECHO else None
        if self.map.fuse(ping.transducer, ping.ranger, distance, reading.stamp_ns):
            self.ledger.fused += 1
        else:
            self._drop(reading, "no echo" if distance is None else "outside the map")

    def _drop(self, reading: RangeReading, reason: str) -> None:
        self.ledger.drop(reason)
        self._drops.append(Drop(reading, reason))

    def _take_drops(self) -> list[Drop]:
        drops, self._drops = self._drops, []
        return drops
