"""How good the maps are: an emulated office, whose truth is known, and what spoils a map of it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from math import radians

from echogrid.drivers.readings import RangeReading
from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.truth import truth
from echogrid.mapping.long_term_map import MapImage
from echogrid.mapping.metrics import MapQuality, quality
from echogrid.mapping.odometry import DifferentialDrive
from echogrid.mapping.pose import Pose
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime import assembly, offline, robot_file
from echogrid.runtime.config import Config, SensorConfig
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.recording import Recording
from echogrid.runtime.simulated_run import simulated_run

OCCUPIED = 0.5
LATE_NS = 100_000_000
TURNING = radians(50.0)
"""rad/s: a tour's turns are at 60 deg/s but for their ends."""


@dataclass(slots=True)
class Tape:
    """Keeps what a run's ticks took in."""

    ranges: list[RangeReading] = field(default_factory=list)
    wheels: list[WheelAngles] = field(default_factory=list)

    def put(self, ranges: tuple[RangeReading, ...], wheels: tuple[WheelAngles, ...]) -> None:
        """Append."""
        self.ranges += ranges
        self.wheels += wheels


@dataclass(frozen=True, slots=True)
class Score:
    """One row of the table."""

    case: str
    quality: MapQuality


def default_config() -> Config:
    """The emulated robot's."""
    return robot_file.load(DEFAULT_ROBOT)


def drive_tour(config: Config, seed: int, metres: float) -> Tape:
    """A simulated run over the given way."""
    tour = office_tour()
    seconds = next(t for t in range(10, 100_000, 10) if tour.distance(t) >= metres)
    tape = Tape()
    run, _ = simulated_run(config, seed, (tape,))
    run.go(float(seconds), lambda _: None)
    return tape


def office_scores(seed: int, metres: float) -> Iterator[Score]:
    """The map of a tour through the office as it should be, and with one thing wrong at a time."""
    config = default_config()
    tape = drive_tour(config, seed, metres)
    cases: dict[str, Callable[[], Recording]] = {
        "as it is": lambda: recording(config, tape),
        "sensor order mirrored": lambda: recording(mirrored(config), tape),
        "wheels of half the size": lambda: recording(half_wheels(config), tape),
        "poses 100 ms late while turning": lambda: late(recording(config, tape)),
    }
    for case, made in cases.items():
        yield Score(case, judge(offline.build(made()).image))


def recording(config: Config, tape: Tape) -> Recording:
    """A tape, as a robot of that configuration understands it."""
    drive: DifferentialDrive = assembly.drive(config)
    poses = [(angles.stamp_ns, drive.update(angles.left, angles.right)) for angles in tape.wheels]
    return Recording(config, poses, [("tape", reading) for reading in tape.ranges])


def judge(image: MapImage) -> MapQuality:
    """The map against the office, where the map has seen something."""
    x, y, _ = office_tour().pose(0.0)
    geometry = image.geometry
    walls, free = truth(office(), geometry.x_centres + x, geometry.y_centres + y, (x, y))
    return quality(image.occupancy > OCCUPIED, walls, (walls | free) & ~image.unknown)


def mirrored(config: Config) -> Config:
    """Left and right sensors taken for each other."""

    def mirror(sensor: SensorConfig) -> SensorConfig:
        return replace(sensor, y_m=-sensor.y_m, yaw_deg=-sensor.yaw_deg)

    return replace(config, sensor=tuple(mirror(sensor) for sensor in config.sensor))


def half_wheels(config: Config) -> Config:
    """Wheels believed to be half as large as they are."""
    radius = config.robot.wheel_radius_m or 0.0
    return replace(config, robot=replace(config.robot, wheel_radius_m=radius / 2.0))


def late(told: Recording) -> Recording:
    """Poses of which those in a quick turn are 100 ms old."""
    poses: list[tuple[int, Pose]] = []
    return replace(told, poses=poses)
