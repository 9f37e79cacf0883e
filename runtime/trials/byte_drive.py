"""The same trial through all bytes: emulated devices on wires in memory, real drivers, and the robot's own
service, as `echogrid run --simulate --goto` runs it, on the course of a job."""

from dataclasses import replace
from operator import attrgetter

from echogrid.drivers.readings import RangeReading
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.hearing import Outing
from echogrid.emulation.plant import Encoders
from echogrid.emulation.robot import EmulatedRobot, RangerSpec
from echogrid.emulation.stalled import StallingBase
from echogrid.emulation.vista import Post
from echogrid.mapping.reckoning import YawRate
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime.emulated import robot_spec, surroundings
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.modes import making
from echogrid.runtime.simulated_run import START_NS, joined
from echogrid.runtime.trials.course import Course, course
from echogrid.runtime.trials.job import Job
from echogrid.runtime.trials.judge import Judge
from echogrid.runtime.trials.pinging import Fired
from echogrid.runtime.trials.rigs import RIGS, Rig
from echogrid.runtime.trials.track import Track
from echogrid.runtime.trials.verdict import Verdict
from echogrid.runtime.voyage import commissioned


class ByteDrive:
    """A job under way. Its rig must have devices: "built-in"; its rangers always hear each other."""

    def __init__(self, job: Job) -> None:
        self.rig: Rig = RIGS[job.rig]()
        self.course: Course = course(job.world, job.seed, self.rig.body.reach)
        config, world = making.brisk(self.rig.config), self.course.arena.world
        began_ns = START_NS - round(self.course.begins_s * SECOND_NS)

        def people_at(now_ns: int) -> tuple[Post, ...]:
            return world.at((now_ns - began_ns) * 1e-9).people

        wheels = self.rig.drive
        encoders = Encoders(job.seed, wheel_radius=wheels.wheel_radius)
        base = StallingBase(world, self.rig.body, self.course.start, people_at, encoders, wheels.track)
        outing = Outing(world, base.pose, job.seed, began_ns)
        self._base = base
        self._judge = Judge(self.course, self.rig, outing, base.plant, START_NS)
        self._fired: list[Fired] = []
        self._seats = {seat.ranger.name: index for index, seat in enumerate(self.rig.seats)}
        self._around = surroundings(outing)
        robot = EmulatedRobot(robot_spec(config), self._overheard, base.shaft, seed=job.seed)
        goal = self._judge.goal
        parts = commissioned(config, making.goto(config, goal.x, goal.y))
        self._run = joined(config, parts, robot)
        self._run.sinks = (self,)
        self._verdict: Verdict | None = None

    @property
    def track(self) -> Track:
        """What happened so far."""
        return self._judge.track

    def done(self) -> Verdict:
        """Drive until it is over, and the motors are let go; what was then counts for nothing."""
        self._run.go(None, lambda _: None)
        assert self._verdict is not None  # nothing else ends the run
        return self._verdict

    def put(
        self, ranges: tuple[RangeReading, ...], _wheels: tuple[WheelAngles, ...], _rates: tuple[YawRate, ...]
    ) -> None:
        """A tick is done."""
        if self._verdict is not None:
            return
        run, judge, now_ns = self._run, self._judge, self._run.clock.now_ns()
        believed = run.fusion.odometry.pose
        self._base.pose(now_ns)
        for reading in ranges:
            self.track.reading(reading)
        judge.hear([reading.stamp_ns for reading in ranges], now_ns)
        judge.see(believed, run.fusion.twist)
        gave_up = run.voyage is not None and run.voyage.end is not None
        outcome = judge.outcome(believed) or ("stuck" if gave_up else "")
        if outcome:
            self._verdict = judge.verdict(outcome, sorted(self._fired, key=attrgetter("stamp_ns")))
            run.stopping = True

    def _overheard(self, ranger: RangerSpec) -> Surroundings:
        """What a ranger has around it; its pings are noted."""
        around = self._around(ranger)

        def ping(fire_ns: int) -> None:
            self._fired.append(Fired(fire_ns, self._seats[ranger.name]))
            around.ping(fire_ns)

        return replace(around, ping=ping)
