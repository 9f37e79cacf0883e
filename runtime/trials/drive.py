"""One drive: plant, rangers, odometry, lookout and pilot on one clock, from the start until it is over."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

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
from echogrid.runtime.config import LoopConfig
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.trials.course import Course, course
from echogrid.runtime.trials.job import Job
from echogrid.runtime.trials.judge import Judge
from echogrid.runtime.trials.pilot import STANDING, Hiring, Robot
from echogrid.runtime.trials.pinging import Pinging
from echogrid.runtime.trials.rigs import RIGS, Rig
from echogrid.runtime.trials.track import Track
from echogrid.runtime.trials.troubles import Troubles
from echogrid.runtime.trials.verdict import Verdict

CONTROL_HZ = 20.0
CONTROL_NS = round(SECOND_NS / CONTROL_HZ)
WHEELS_NS = 20_000_000
_SPREAD = 2.5e-5
"""m^2 per m: what the odometry takes the wheels' variance for."""


class Drive:
    """A job under way."""

    def __init__(self, job: Job, pilots: Mapping[str, Hiring]) -> None:
        self.rig: Rig = RIGS[job.rig]()
        self.course: Course = course(job.world, job.seed, self.rig.body.reach)
        world, begins_ns = self.course.arena.world, round(self.course.begins_s * SECOND_NS)
        motors = self.rig.drive

        def moment(now_ns: int) -> Moment:
            return world.at((now_ns + begins_ns) * 1e-9)

        self.plant = Plant(world, self.rig.body, motors, self.course.start, lambda at: moment(at).people)
        outing = Outing(world, self.plant.pose_at, job.seed, -begins_ns)
        troubles = Troubles(job, len(self.rig.seats))
        self._pinging = Pinging(self.rig, outing, troubles, crosstalk=job.crosstalk)
        self._judge = Judge(self.course, self.rig, outing, self.plant)
        self._encoders = Encoders(job.seed, wheel_radius=motors.wheel_radius)
        self._odometry = Odometry(
            Differential(motors.wheel_radius, motors.wheel_radius, motors.track, _SPREAD)
        )
        self._poses = PoseBuffer()
        config = replace(self.rig.config, loop=LoopConfig(CONTROL_HZ))
        self._rangers = {seat.ranger.name: seat.ranger for seat in self.rig.seats}
        reach = self.rig.body.reach
        self._pilot = pilots[job.pilot](Robot(reach, config, partial(self.course.floor_plan, reach)))
        self._lookout = assembly.lookout(config, self._pilot.tracker)
        self._told: list[RangeReading] = []
        """Since the pilot's last step."""
        self._unplaced: list[RangeReading] = []
        self._asked = STANDING
        self._odometry.update(0, self._encoders.read(self.plant.wheels))
        self._poses.add(0, self._odometry.pose)

    @property
    def track(self) -> Track:
        """What happened so far."""
        return self._judge.track

    def done(self) -> Verdict:
        """Drive until it is over."""
        outcome = ""
        while not outcome:
            self._step()
            outcome = self._judge.outcome(self._believed)
        return self._judge.verdict(outcome, self._pinging.fired)

    @property
    def _believed(self) -> Pose:
        """Where the robot takes itself to be, as it started at zero."""
        tracker = self._pilot.tracker
        return tracker.pose if tracker else self._odometry.pose

    def _step(self) -> None:
        plant = self.plant
        plant.step()
        now_ns = plant.now_ns
        if now_ns % WHEELS_NS == 0:
            self._poses.add(now_ns, self._odometry.update(now_ns, self._encoders.read(plant.wheels)))
        for reading in self._pinging.advance(now_ns):
            self.track.reading(reading)
            self._told.append(reading)
        if now_ns % CONTROL_NS == 0:
            self._look(now_ns)
            self._steer(now_ns)

    def _look(self, now_ns: int) -> None:
        """Take in what was told, as the tick of the robot's service does."""
        placed = self._placed()
        self._lookout.hear(self._told, now_ns)
        self._lookout.see(placed, self._odometry.pose, now_ns)
        self._told.clear()
        for ping in placed:
            self._pilot.hear(ping)
        self._judge.hear([ping.reading.stamp_ns for ping in placed], now_ns)

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

    def _steer(self, now_ns: int) -> None:
        pose, local = self._odometry.pose, self._lookout.local
        asked = self._pilot.step(now_ns, local, pose, self._asked, self._judge.goal)
        if self._pilot.guarded:
            asked = self._lookout.allowed(pose, now_ns, asked)
        self._asked = asked
        self.plant.ask(asked.speed, asked.turn_rate)
        self._judge.see(pose, asked)
