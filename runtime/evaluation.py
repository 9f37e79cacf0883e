"""How good the maps are: an emulated office, whose truth is known, and what spoils a map of it."""

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import atan2, degrees
from pathlib import Path
from statistics import mean

import numpy as np

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.emulation.motion import Tour
from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.round import Round
from echogrid.emulation.truth import truth
from echogrid.emulation.world import World
from echogrid.mapping.long_term_map import MapImage
from echogrid.mapping.metrics import MapQuality, quality
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.pose_buffer import PoseBuffer
from echogrid.mapping.reckoning import YawRate
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime import assembly, offline, robond, robot_file
from echogrid.runtime.config import Config
from echogrid.runtime.emulated import DEFAULT_ROBOT, office_round
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.recording import Recording
from echogrid.runtime.simulated_run import START_NS, simulated_run
from echogrid.runtime.wall_check import score, side_walls

OCCUPIED = 0.5
LATE_NS = 100_000_000
POST = (0.15, 1.5, 0.1)
"""x, y and radius, m."""
TURNING = Tour(((0.0, 0.0), (0.3, 0.0)), frozenset({0, 1}))
"""Full turns beside the post, at 60 deg/s."""
HALL_M = 6.0
"""Half the side of the hall around it, beyond every ranger's reach."""


@dataclass(slots=True)
class Tape:
    """Keeps what a run's ticks took in."""

    ranges: list[RangeReading] = field(default_factory=list)
    wheels: list[WheelAngles] = field(default_factory=list)

    def put(
        self, ranges: tuple[RangeReading, ...], wheels: tuple[WheelAngles, ...], _: tuple[YawRate, ...]
    ) -> None:
        """Append."""
        self.ranges += ranges
        self.wheels += wheels


def default_config() -> Config:
    """The emulated robot's."""
    return robot_file.load(DEFAULT_ROBOT)


def drive_tour(config: Config, seed: int, metres: float) -> Tape:
    """A simulated run over the given way."""
    tour = office_round(config)
    seconds = next(t for t in range(10, 1_000_000, 10) if tour.distance(t) >= metres)
    tape = Tape()
    run, _ = simulated_run(config, seed)
    run.sinks = (tape,)
    run.go(float(seconds), lambda _: None)
    return tape


def tables(seed: int, metres: float, recording: Path | None) -> Iterator[str]:
    """Markdown: everything that is measured."""
    yield from office_table(seed, metres)
    yield ""
    yield from post_table(seed)
    if recording is not None:
        yield ""
        yield from robond_table(recording)


def office_table(seed: int, metres: float) -> Iterator[str]:
    """Rows of Markdown: the map of a tour through the office as it should be, and with one thing wrong."""
    config = default_config()
    tape = drive_tour(config, seed, metres)
    yield f"| office, {metres:g} m, {len(tape.ranges)} pings | F1 | precision | recall | phantoms |"
    yield "|---|---|---|---|---|"
    for case, recording in office_cases(config, tape):
        q = judge(offline.build(recording).image, start_of(office_tour(), tape))
        yield f"| {case} | {q.f1:.3f} | {q.precision:.3f} | {q.recall:.3f} | {100.0 * q.phantoms:.1f} % |"


def office_cases(config: Config, tape: Tape) -> Iterator[tuple[str, Recording]]:
    """The same tape rightly understood, and wrongly in one way at a time."""
    right = recorded(config, tape)
    yield "as it is", right
    yield "sensor order mirrored", recorded(mirrored(config), tape)
    yield "wheels of half the size", recorded(half_wheels(config), tape)
    yield "poses 100 ms late", replace(right, poses=late(right.poses))


def post_table(seed: int) -> Iterator[str]:
    """Rows of Markdown: where a post is heard by a robot that turns, if time is true, and if it is not."""
    config = default_config()
    tape = turn_beside_post(config, seed)
    poses = recorded(config, tape).poses
    yield f"| a post at {POST[1]} m, turning at 60 deg/s | off the axis, on the mean | pings |"
    yield "|---|---|---|"
    for case, told in (("as it is", poses), ("poses 100 ms late", late(poses))):
        bearings = post_bearings(config, tape, told)
        yield f"| {case} | {degrees(mean(bearings)):+.1f} deg | {len(bearings)} |"


def robond_table(folder: Path) -> Iterator[str]:
    """Rows of Markdown: the walls of the RoboND recording, rightly and with the sensor order mirrored."""
    right = robond.read(folder)
    walls = side_walls(right, "sonar0", "sonar7")
    path = np.array([[pose.x, pose.y] for _, pose in right.poses])
    yield "| RoboND recording | wall bins | drawn within 10 cm | path cells occupied |"
    yield "|---|---|---|---|"
    backwards = robond.configuration(robond.BEARINGS_DEG[::-1])
    for case, recording in (
        ("as it is", right),
        ("sensor order mirrored", robond.read(folder, backwards)),
    ):
        found = score(offline.build(recording).image, walls, path)
        yield f"| {case} | {found.bins} | {100.0 * found.drawn:.1f} % | {100.0 * found.path_blocked:.2f} % |"


def turn_beside_post(config: Config, seed: int) -> Tape:
    """A simulated run of a robot which turns round and round beside a post, in an empty hall."""
    corners = [(-HALL_M, -HALL_M), (HALL_M, -HALL_M), (HALL_M, HALL_M), (-HALL_M, HALL_M)]
    walls = [(*corner, *corners[(index + 1) % 4]) for index, corner in enumerate(corners)]
    world = World("post", np.array(walls), np.zeros(len(walls), np.bool_), np.array([POST]))
    run, _ = simulated_run(config, seed, world, TURNING)
    tape = Tape()
    run.sinks = (tape,)
    run.go(120.0, lambda _: None)
    return tape


def post_bearings(config: Config, tape: Tape, told: list[tuple[int, Pose]]) -> list[float]:
    """rad: how far to the left of the transducer's axis the post is for each echo, by these poses."""
    mounts = {sensor.name: sensor.ranger().mount for sensor in config.sensor}
    start = start_of(TURNING, tape)
    poses = PoseBuffer(None)
    for stamp_ns, pose in told:
        poses.add(stamp_ns, start.compose(pose))
    bearings = []
    for reading in tape.ranges:
        robot = poses.at(reading.stamp_ns)
        if reading.outcome is Outcome.ECHO and isinstance(robot, Pose):
            transducer = robot.compose(mounts[reading.sensor])
            towards = atan2(POST[1] - transducer.y, POST[0] - transducer.x)
            bearings.append(wrap_angle(towards - transducer.yaw))
    return bearings


def recorded(config: Config, tape: Tape) -> Recording:
    """A tape, as a robot of that configuration understands it."""
    odometry = assembly.odometry(config)
    poses = [
        (angles.stamp_ns, odometry.update(angles.stamp_ns, angles.both, angles.restarted))
        for angles in tape.wheels
    ]
    return Recording(config, poses, [("tape", reading) for reading in tape.ranges])


def start_of(tour: Round, tape: Tape) -> Pose:
    """Where the robot truly was when its wheels were first read: the map frame's origin."""
    return Pose(*tour.pose((tape.wheels[0].stamp_ns - START_NS) / SECOND_NS))


def judge(image: MapImage, start: Pose) -> MapQuality:
    """The map, whose frame stands at `start` and is not turned, against the office where it has seen it."""
    geometry = image.geometry
    x, y = geometry.x_centres + start.x, geometry.y_centres + start.y
    walls, free = truth(office(), x, y, (start.x, start.y))
    return quality((image.occupancy > OCCUPIED) & ~image.unknown, walls, (walls | free) & ~image.unknown)


def mirrored(config: Config) -> Config:
    """Left and right sensors taken for each other."""
    sensors = (replace(sensor, y_m=-sensor.y_m, yaw_deg=-sensor.yaw_deg) for sensor in config.sensor)
    return replace(config, sensor=tuple(sensors))


def half_wheels(config: Config) -> Config:
    """Wheels believed to be half as large as they are."""
    radius = config.robot.wheel_radius_m or 0.0
    return replace(config, robot=replace(config.robot, wheel_radius_m=radius / 2.0))


def late(poses: list[tuple[int, Pose]]) -> list[tuple[int, Pose]]:
    """Each pose replaced by that of 100 ms before."""
    stamps = [stamp_ns for stamp_ns, _ in poses]
    return [
        (stamp_ns, poses[max(bisect_right(stamps, stamp_ns - LATE_NS) - 1, 0)][1]) for stamp_ns, _ in poses
    ]
