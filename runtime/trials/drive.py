"""One drive: plant, rangers, odometry, lookout and pilot on one clock, from the start until it is over."""

import hashlib
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import hypot

from echogrid.drivers.readings import RangeReading
from echogrid.emulation.hearing import Outing
from echogrid.emulation.plant import Encoders, Plant
from echogrid.emulation.world import Moment
from echogrid.mapping.kinematics import Differential
from echogrid.mapping.odometry import Odometry
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose
from echogrid.mapping.pose_buffer import PoseBuffer, PoseMiss
from echogrid.runtime import assembly
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.trials.course import GOAL_M, Course, course
from echogrid.runtime.trials.detection import Detection
from echogrid.runtime.trials.job import Job
from echogrid.runtime.trials.pilot import STANDING, Hiring, Robot
from echogrid.runtime.trials.pinging import Pinging
from echogrid.runtime.trials.rigs import CONTROL_HZ, RIGS, Rig
from echogrid.runtime.trials.troubles import Troubles
from echogrid.runtime.trials.verdict import Bump, Verdict, Watch

CONTROL_NS = round(SECOND_NS / CONTROL_HZ)
WHEELS_NS = 20_000_000
_PATIENCE = 4.0
"""So many times as long as the shortest way takes at full speed,"""
_GRACE_S = 30.0
"""and so much more, it may take."""
_STUCK_NS = 20 * SECOND_NS
_STUCK_M = 0.3
"""Who was nowhere farther than this for so long is stuck."""
_SPREAD = 2.5e-5
"""m^2 per m: what the odometry takes the wheels' variance for."""

COLUMNS = (
    "time_s",
    "x_m",
    "y_m",
    "yaw_rad",
    "odometry_x_m",
    "odometry_y_m",
    "odometry_yaw_rad",
    "asked_mps",
    "asked_rad_s",
    "clearance_m",
)
Row = tuple[float, ...]
"""Of these. The true pose is that of the map frame."""


@dataclass(slots=True)
class Track:
    """What happened, step by step, and its digest."""

    rows: list[Row] = field(default_factory=list)
    _sum: "hashlib._Hash" = field(default_factory=hashlib.sha256)

    def step(self, row: Row) -> None:
        """A step of the pilot."""
        self.rows.append(row)
        self._sum.update(struct.pack(f"<{len(row)}d", *row))

    def reading(self, reading: RangeReading) -> None:
        """What a ranger said."""
        told = f"{reading.sensor} {reading.outcome.value} {reading.stamp_ns} {reading.distance.hex()}"
        self._sum.update(told.encode())

    def digest(self) -> str:
        """Of all so far."""
        return self._sum.hexdigest()[:32]


class Drive:
    """A job under way."""

    def __init__(self, job: Job, pilots: Mapping[str, Hiring]) -> None:
        self.rig: Rig = RIGS[job.rig]()
        self.course: Course = course(job.world, job.seed, self.rig.body.reach)
        self.track = Track()
        world, begins_ns = self.course.arena.world, round(self.course.begins_s * SECOND_NS)
        motors = self.rig.drive

        def moment(now_ns: int) -> Moment:
            return world.at((now_ns + begins_ns) * 1e-9)

        self.plant = Plant(world, self.rig.body, motors, self.course.start, lambda at: moment(at).people)
        outing = Outing(world, self.plant.pose_at, job.seed, -begins_ns)
        troubles = Troubles(job, len(self.rig.seats))
        self._pinging = Pinging(self.rig, outing, troubles, crosstalk=job.crosstalk)
        self._detection = Detection(self.rig, outing, self.plant)
        self._encoders = Encoders(job.seed, wheel_radius=motors.wheel_radius)
        self._odometry = Odometry(
            Differential(motors.wheel_radius, motors.wheel_radius, motors.track, _SPREAD)
        )
        self._poses = PoseBuffer()
        self._lookout = assembly.lookout(self.rig.config)
        self._rangers = {seat.ranger.name: seat.ranger for seat in self.rig.seats}
        self._pilot = pilots[job.pilot](Robot(self.rig.body.reach, self.rig.config))
        self._watch = Watch()
        self._told: list[RangeReading] = []
        """Since the pilot's last step."""
        self._unplaced: list[RangeReading] = []
        self._asked = STANDING
        self._goal = Pose(*self.course.start).inverse().compose(Pose(*self.course.goal))
        self._odometry.update(0, self._encoders.read(self.plant.wheels))
        self._poses.add(0, self._odometry.pose)
        self._anchor = 0, self.course.start
        self._heard = 0

    def done(self) -> Verdict:
        """Drive until it is over."""
        at_best_s = self.course.shortest / self.rig.drive.speed
        last_ns = round((_PATIENCE * at_best_s + _GRACE_S) * SECOND_NS)
        outcome = ""
        while not outcome:
            self._step()
            outcome = self._outcome(last_ns)
        return self._verdict(outcome, at_best_s)

    def _step(self) -> None:
        plant = self.plant
        plant.step()
        now_ns = plant.now_ns
        if now_ns % WHEELS_NS == 0:
            self._roll(now_ns)
        for reading in self._pinging.advance(now_ns):
            self.track.reading(reading)
            self._told.append(reading)
        if now_ns % CONTROL_NS == 0:
            self._steer(now_ns)

    def _roll(self, now_ns: int) -> None:
        self._poses.add(now_ns, self._odometry.update(now_ns, self._encoders.read(self.plant.wheels)))

    def _placed(self) -> list[PlacedPing]:
        """Of the readings so far those whose poses are known by now; the others wait."""
        waiting, self._unplaced = self._unplaced + self._told, []
        placed = []
        for reading in waiting:
            pose, ranger = self._poses.at(reading.stamp_ns), self._rangers[reading.sensor]
            if isinstance(pose, Pose):
                placed.append(PlacedPing(reading, ranger, pose.compose(ranger.mount)))
            elif pose is PoseMiss.NOT_YET:
                self._unplaced.append(reading)
        return placed

    def _look(self, now_ns: int) -> None:
        """Take in what was told, as the tick of the robot's service does."""
        placed = self._placed()
        self._lookout.hear(self._told, now_ns)
        self._lookout.see(placed, self._odometry.pose, now_ns)
        self._told.clear()
        for ping in placed:
            self._pilot.hear(ping)
        self._watch.latencies_ns += [now_ns - ping.reading.stamp_ns for ping in placed]
        self._heard += len(placed)

    def _steer(self, now_ns: int) -> None:
        self._look(now_ns)
        pose, plant = self._odometry.pose, self.plant
        asked = self._pilot.step(now_ns, self._lookout.local, pose, self._asked, self._goal)
        if self._pilot.guarded:
            asked = self._lookout.allowed(pose, now_ns, asked)
        self._asked = asked
        plant.ask(asked.speed, asked.turn_rate)
        clearance = plant.gaps().least
        self._watch.see(clearance, plant.speed)
        by_wheels = (pose.x, pose.y, pose.yaw)
        self.track.step((now_ns * 1e-9, *plant.pose, *by_wheels, asked.speed, asked.turn_rate, clearance))

    def _outcome(self, last_ns: int) -> str:
        """What became of it; nothing yet: ""."""
        now_ns, (x, y, yaw) = self.plant.now_ns, self.plant.pose
        believed = self._odometry.pose
        if hypot(believed.x - self._goal.x, believed.y - self._goal.y) <= GOAL_M:
            return "reached"
        since_ns, (from_x, from_y, _) = self._anchor
        if hypot(x - from_x, y - from_y) > _STUCK_M:
            self._anchor = now_ns, (x, y, yaw)
        elif now_ns - since_ns >= _STUCK_NS:
            return "stuck"
        return "late" if now_ns >= last_ns else ""

    def _verdict(self, outcome: str, at_best_s: float) -> Verdict:
        plant, watch = self.plant, self._watch
        time_s = plant.now_ns * 1e-9
        least, low = watch.clearance()
        x, y, _ = plant.pose
        return Verdict(
            outcome=outcome,
            time_s=time_s,
            travelled=plant.travelled,
            shortest=self.course.shortest,
            time_ratio=time_s / at_best_s,
            goal_error=hypot(x - self.course.goal[0], y - self.course.goal[1]),
            least_clearance=least,
            low_clearance=low,
            near_misses=watch.near_misses,
            reversals=watch.reversals,
            latency_s=watch.latency_s(),
            pings=self._heard,
            digest=self.track.digest(),
            bumps=tuple(
                Bump.judged(contact, self._detection.possible(contact, reversed(self._pinging.fired)))
                for contact in plant.contacts
            ),
        )
