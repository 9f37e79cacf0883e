"""The tick: readings in, the robot's pose, both grids and the obstacle view out.

A pure function of (state, tick time, ordered readings): no clock, file or thread is touched, so the same
readings at the same ticks give the same bits.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from echogrid.drivers.readings import RangeReading, Reading, WheelReading
from echogrid.mapping.ledger import Ledger
from echogrid.mapping.long_term_map import MapImage
from echogrid.mapping.lookout import Lookout
from echogrid.mapping.mapper import Drop, Mapper
from echogrid.mapping.odometry import Covariance, Odometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.stuck import StuckWatch
from echogrid.mapping.virtual_sensor import ObstacleView
from echogrid.mapping.wheel_pair import WheelAngles, WheelPair
from echogrid.runtime.listening import Listening


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What a tick gives to the outputs."""

    stamp_ns: int
    pose: Pose
    """In the odom frame, at the newest wheel reading."""
    covariance: Covariance
    """Of that pose, as far as dead reckoning knows."""
    travelled: float
    """m."""
    view: ObstacleView
    ranges: tuple[RangeReading, ...]
    """Taken in by this tick, in order; without those which came too late for the map, or only listened."""
    wheels: tuple[WheelAngles, ...]
    """Both wheels at common stamps, completed by this tick, in order."""
    drops: tuple[Drop, ...]
    restarts: int
    """How often a wheel restarted so far, and what both turned meanwhile was lost."""


class Fusion:
    """All state of the loop. One thread owns it."""

    def __init__(self, mapper: Mapper, odometry: Odometry, lookout: Lookout) -> None:
        self.listening = Listening()
        self.stuck = StuckWatch()
        self._mapper = mapper
        self._odometry = odometry
        self._lookout = lookout
        self._pair = WheelPair()
        self._moved_ns = -(1 << 62)

    @property
    def ledger(self) -> Ledger:
        """The books of the range readings."""
        return self._mapper.ledger

    @property
    def waiting(self) -> int:
        """Range readings neither fused nor dropped yet."""
        return self._mapper.waiting

    @property
    def unpaired(self) -> int:
        """Wheel readings that found no partner."""
        return self._pair.unpaired

    @property
    def restarts(self) -> int:
        """How often a wheel restarted, and what both turned meanwhile was lost."""
        return self._pair.restarts

    def tick(self, now_ns: int, readings: Sequence[Reading]) -> Snapshot:
        """Advance to `now_ns` with what came in since the last tick, in order of arrival."""
        wheels = self._move(readings)
        ranges = tuple(reading for reading in readings if isinstance(reading, RangeReading))
        for reading in ranges:
            self.listening.take(reading)
            self.stuck.see(reading, self._odometry.pose)
            self._mapper.add(reading)
        placed, drops = self._mapper.advance()
        self._lookout.hear(ranges)
        self._lookout.see(placed, self._odometry.pose, now_ns)
        view = self._lookout.view(self._odometry.pose, now_ns)
        late = {id(drop.reading) for drop in drops if drop.reason in ("late", "listened")}
        used = tuple(reading for reading in ranges if id(reading) not in late)
        return Snapshot(
            now_ns,
            self._odometry.pose,
            self._odometry.covariance,
            self._odometry.travelled,
            view,
            used,
            tuple(wheels),
            tuple(drops),
            self._pair.restarts,
        )

    def overflow(self, readings: Sequence[Reading]) -> None:
        """Account for readings which gave way before a tick could take them."""
        for reading in readings:
            if isinstance(reading, RangeReading):
                self._mapper.refuse(reading, "queue full")

    def finish(self) -> tuple[Drop, ...]:
        """Fuse what can still be placed; nothing more will come."""
        return tuple(self._mapper.finish())

    def map_image(self) -> MapImage:
        """The long-term map as it is now."""
        return self._mapper.map.render()

    def _move(self, readings: Sequence[Reading]) -> list[WheelAngles]:
        """Dead reckoning up to the newest moment for which both wheels are known."""
        moves: list[WheelAngles] = []
        for reading in readings:
            if isinstance(reading, WheelReading):
                moves += [angles for angles in self._paired(reading) if self._move_to(angles)]
        return moves

    def _move_to(self, angles: WheelAngles) -> bool:
        """Whether this is later than the last, and so a move."""
        if angles.stamp_ns <= self._moved_ns:
            return False
        self._moved_ns = angles.stamp_ns
        pose = self._odometry.update(angles.stamp_ns, (angles.left, angles.right), angles.restarted)
        return self._mapper.add_pose(angles.stamp_ns, pose)

    def _paired(self, reading: WheelReading) -> list[WheelAngles]:
        if reading.wheel == "right":
            return self._pair.right(reading)
        self._pair.left(reading)
        return []
