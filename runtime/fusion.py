"""The tick: readings in, the robot's pose, both grids and the obstacle view out.

A pure function of (state, tick time, ordered readings): no clock, file or thread is touched, so the same
readings at the same ticks give the same bits.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from echogrid.drivers.readings import GyroReading, RangeReading, Reading, WheelReading
from echogrid.mapping.free_path import STANDING, FreePath
from echogrid.mapping.ledger import Ledger
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.long_term_map import MapImage
from echogrid.mapping.lookout import Lookout
from echogrid.mapping.mapper import Drop, Mapper
from echogrid.mapping.odometry import Covariance, Odometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.reckoning import Reckoning, StampedPose, YawRate
from echogrid.mapping.stuck import StuckWatch
from echogrid.mapping.twist import Twist
from echogrid.mapping.virtual_sensor import ObstacleView
from echogrid.mapping.wheel_pair import WheelAngles, WheelPair
from echogrid.runtime.listening import Listening


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What a tick gives to the outputs."""

    stamp_ns: int
    pose: Pose
    """In the odom frame, at the newest wheel reading, or as far as the gyro covers those."""
    pose_ns: int | None
    """Its stamp; None before the first."""
    covariance: Covariance
    """Of that pose, as far as dead reckoning knows."""
    travelled: float
    """m."""
    view: ObstacleView
    ranges: tuple[RangeReading, ...]
    """Taken in by this tick, in order; without those which came too late for the map, or only listened."""
    wheels: tuple[WheelAngles, ...]
    """Both wheels at common stamps, completed by this tick, in order."""
    rates: tuple[YawRate, ...]
    """Of the gyro, taken in by this tick, in order; without those which came too late for the odometry."""
    drops: tuple[Drop, ...]
    restarts: int
    """How often a wheel restarted so far, and what both turned meanwhile was lost."""
    slips: int
    """How often wheels and gyro began to disagree so far."""
    slipping: bool
    """Whether they do."""


class Fusion:
    """All state of the loop. One thread owns it."""

    def __init__(self, mapper: Mapper, odometry: Odometry, lookout: Lookout) -> None:
        self.listening = Listening()
        self.stuck = StuckWatch()
        self.twist: Twist = STANDING
        """What the robot is commanded to do, as far as anybody says: its way is looked at."""
        self._mapper = mapper
        self._odometry = odometry
        self._reckoning = Reckoning(odometry)
        self._lookout = lookout
        self._pair = WheelPair(odometry.kinematics.wheels)
        self._pose_ns: int | None = None

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

    @property
    def late_rates(self) -> int:
        """The gyro's rates that came too late for the odometry."""
        return self._reckoning.refused

    @property
    def local(self) -> LocalGrid:
        """The grid around the robot; to be read, not written."""
        return self._lookout.local

    @property
    def odometry(self) -> Odometry:
        """Where the robot is, and how sure that is."""
        return self._odometry

    def tick(self, now_ns: int, readings: Sequence[Reading]) -> Snapshot:
        """Advance to `now_ns` with what came in since the last tick, in order of arrival."""
        wheels, rates = self._move(readings)
        ranges = tuple(reading for reading in readings if isinstance(reading, RangeReading))
        for reading in ranges:
            self.listening.take(reading)
            self.stuck.see(reading, self._odometry.pose)
            self._mapper.add(reading)
        placed, drops = self._mapper.advance()
        self._lookout.hear(ranges, now_ns)
        self._lookout.see(placed, self._odometry.pose, now_ns)
        view = self._lookout.view(self._odometry.pose, now_ns, self.twist)
        late = {id(drop.reading) for drop in drops if drop.reason in ("late", "listened")}
        used = tuple(reading for reading in ranges if id(reading) not in late)
        gyro = self._odometry.yaw_fusion
        return Snapshot(
            now_ns,
            self._odometry.pose,
            self._pose_ns,
            self._odometry.covariance,
            self._odometry.travelled,
            view,
            used,
            tuple(wheels),
            tuple(rates),
            tuple(drops),
            self._pair.restarts,
            gyro.slips if gyro else 0,
            gyro is not None and gyro.slipping,
        )

    def overflow(self, readings: Sequence[Reading]) -> None:
        """Account for readings which gave way before a tick could take them."""
        for reading in readings:
            if isinstance(reading, RangeReading):
                self._mapper.refuse(reading, "queue full")

    def finish(self) -> tuple[Drop, ...]:
        """Fuse what can still be placed; nothing more will come."""
        self._placed(self._reckoning.finish())
        return tuple(self._mapper.finish())

    def path(self, now_ns: int, twist: Twist) -> FreePath:
        """How far, and how fast, the robot may go with any twist, by what the last tick knew."""
        return self._lookout.path(self._odometry.pose, now_ns, twist)

    def view(self, now_ns: int, twist: Twist) -> ObstacleView:
        """The obstacles, and what stops whoever drives with any twist, by what the last tick knew."""
        return self._lookout.view(self._odometry.pose, now_ns, twist)

    def allowed(self, now_ns: int, wish: Twist) -> Twist:
        """The safe part of a wish, by what the last tick knew."""
        return self._lookout.allowed(self._odometry.pose, now_ns, wish)

    def map_image(self) -> MapImage:
        """The long-term map as it is now."""
        return self._mapper.map.render()

    def _move(self, readings: Sequence[Reading]) -> tuple[list[WheelAngles], list[YawRate]]:
        """Dead reckoning up to the newest moment for which both wheels are known, and the gyro if there is
        one; what was taken in."""
        wheels: list[WheelAngles] = []
        rates: list[YawRate] = []
        for reading in readings:
            if isinstance(reading, WheelReading):
                wheels += [angles for angles in self._pair.take(reading) if self._reckoning.wheels(angles)]
            elif isinstance(reading, GyroReading):
                rate = YawRate(reading.stamp_ns, reading.rate)
                rates += [rate] if self._reckoning.rate(rate) else []
        self._placed(self._reckoning.poses())
        return wheels, rates

    def _placed(self, poses: Sequence[StampedPose]) -> None:
        for stamp_ns, pose in poses:
            self._pose_ns = stamp_ns
            self._mapper.add_pose(stamp_ns, pose)
