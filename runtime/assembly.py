"""From a configuration to the parts of a run: one place where they are put together."""

from collections.abc import Callable, Mapping, Sequence
from math import radians
from pathlib import Path
from types import MappingProxyType
from typing import Any

from echogrid.drivers.device import BusLine, Device
from echogrid.drivers.sound import speed_of_sound
from echogrid.drivers.throttle import Throttle
from echogrid.mapping.analytical_model import Analytical
from echogrid.mapping.braking import Brakes
from echogrid.mapping.company import PAUSE_NS
from echogrid.mapping.empirical_model import EmpiricalOfEach
from echogrid.mapping.footprint import Footprint
from echogrid.mapping.free_path import PathSensor, PathSight
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.gyro import Gyro
from echogrid.mapping.kinematics import Ackermann, Differential, Tricycle, skid_steer
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.long_term_map import LongTermMap
from echogrid.mapping.lookout import Lookout, Readers
from echogrid.mapping.mapper import Mapper
from echogrid.mapping.odometry import Odometry
from echogrid.mapping.planning.tracking import PlanTracker
from echogrid.mapping.pose import Pose
from echogrid.mapping.pose_buffer import PoseBuffer
from echogrid.mapping.sonar_model import Form, SonarModel
from echogrid.mapping.stop_layer import StopLayer, StopZone
from echogrid.mapping.subjective_model import Subjective
from echogrid.mapping.theories import Beliefs, maker
from echogrid.mapping.theory import Theory
from echogrid.mapping.twist import Twist
from echogrid.mapping.verification import Believer, Verifier
from echogrid.mapping.virtual_sensor import Sight, VirtualSensor
from echogrid.mapping.yaw_fusion import YawFusion
from echogrid.runtime import sonar_model_file
from echogrid.runtime.config import Config
from echogrid.runtime.errors import ConfigError, UsageError
from echogrid.runtime.fusion import Fusion
from echogrid.runtime.hull import footprint
from echogrid.runtime.lines import lines
from echogrid.runtime.toml_values import Problem

MOST_CELLS = 4e7
"""A map of 120 MB by Bayes, of 1.4 GB by calibrated evidence."""
SECOND_NS = 1_000_000_000

Drive = Differential | Tricycle | Ackermann

_CYCLES = 4.0
"""In so many cycles of the rangers what stands answers once."""


def parts(
    config: Config,
    beacons: Sequence[tuple[str, Device[Any, Any]]] = (),
    throttles: Mapping[str, Throttle] = MappingProxyType({}),
    tracker: PlanTracker | None = None,
) -> tuple[list[BusLine[Any, Any]], Fusion]:
    """The devices of each bus, and the tick's state. Raises ConfigError with all that a run lacks.

    `beacons` are devices that only send, each with its bus; `throttles` those of the wheels that shall be
    driven, by name; `tracker` knows where the robot is on a floor plan.
    """
    found: list[Problem] = []
    devices: list[BusLine[Any, Any]] = []
    try:
        devices = lines(config, throttles, beacons)
    except ConfigError as error:
        found += error.found
    for part in (geometry, drive, lookout):
        try:
            part(config)
        except ConfigError as error:
            found += error.found
    if found:
        raise ConfigError(found)
    return devices, fusion(config, tracker)


def fusion(config: Config, tracker: PlanTracker | None = None) -> Fusion:
    """The tick's state. Raises ConfigError when the configuration lacks what a run needs."""
    poses = PoseBuffer(widest_gap_ns=pose_gap_ns(config))
    return Fusion(mapper(config, geometry(config), poses), odometry(config), lookout(config, tracker))


def lookout(config: Config, tracker: PlanTracker | None = None) -> Lookout:
    """What looks for obstacles; with a floor plan its walls are known.

    Raises ConfigError if it could not look beyond the robot itself.
    """
    cells = round(config.local.size_m / config.local.resolution_m)
    local = LocalGrid(
        config.local.resolution_m, cells, config.map.tolerance_m, config.local.fade_s, config.map.no_echo
    )
    seen, outline = sight(config), footprint(config)
    zone = StopZone(
        seen.stop_distance, seen.ahead, seen.stale_ns, outline if config.robot.footprint else None
    )
    stop = StopLayer((sensor.ranger() for sensor in config.sensor), zone)
    readers = Readers(
        VirtualSensor(seen, config.local.resolution_m, cells),
        PathSensor(outline, path_sight(config), config.local.resolution_m, cells),
        config.avoid.unknown,
        config.avoid.slow_mps,
        round(config.avoid.reaction_ms * 1e6 + SECOND_NS / config.loop.rate_hz),
        max(PAUSE_NS, round(_CYCLES * len(config.firing.groups) * (config.firing.gap_ms or 0.0) * 1e6)),
    )
    _require_room(config, outline)
    return Lookout(local, readers, stop, verifier(config), tracker)


def sight(config: Config) -> Sight:
    """How the virtual sensor looks around."""
    return Sight(
        sectors=config.obstacle.sectors,
        horizon=config.obstacle.horizon_m,
        stale_ns=round(config.obstacle.stale_s * SECOND_NS),
        stop_distance=config.obstacle.stop_distance_m,
        unknown=config.avoid.unknown,
    )


def path_sight(config: Config) -> PathSight:
    """How the robot's way is looked at."""
    avoid, limits = config.avoid, config.drive
    return PathSight(
        Brakes(avoid.deceleration_mps2, avoid.margin_m),
        avoid.unknown,
        avoid.slow_mps,
        avoid.skin_m,
        avoid.known_part,
        Twist(limits.max_speed_mps, radians(limits.max_turn_dps)),
        config.obstacle.horizon_m,
        stale_ns=round(config.obstacle.stale_s * SECOND_NS),
    )


def _require_room(config: Config, outline: Footprint) -> None:
    """The horizon, and half the local grid, must lie beyond the footprint."""
    least = outline.reach + 2.0 * config.local.resolution_m
    beyond = f"must reach beyond the robot itself: its outline ends {outline.reach:.2f} m from base_link"
    if config.obstacle.horizon_m <= least:
        raise ConfigError([(("obstacle", "horizon_m"), f"`horizon_m` {beyond}")])
    if config.local.size_m / 2.0 <= least:
        raise ConfigError([(("local", "size_m"), f"half of `size_m` {beyond}")])


def mapper(config: Config, area: GridGeometry, poses: PoseBuffer) -> Mapper:
    """The long-term map over an area, and what feeds it."""
    long_term = LongTermMap(area, config.map.tolerance_m, theory(config))
    rangers = (sensor.ranger() for sensor in config.sensor)
    return Mapper(rangers, poses, long_term, verifier=verifier(config))


def theory(config: Config) -> Callable[[GridGeometry], Theory]:
    """What makes a grid of the configured theory."""
    return maker(config.map.theory, Beliefs(sonar_model(config), config.map.no_echo))


def sonar_model(config: Config) -> SonarModel:
    """The configured one. Raises UsageError for a model's file that can't be read."""
    area = config.map
    if area.model == "empirical" and area.model_file:
        return EmpiricalOfEach(sonar_model_file.read(Path(area.model_file)), subjective(config))
    radius_mm, khz = area.transducer_radius_mm, area.transducer_khz
    if area.model == "analytical" and radius_mm and khz:
        return Analytical(radius_mm * 1e-3, speed_of_sound(config.robot.air_temperature_c) / (khz * 1e3))
    return subjective(config)


def subjective(config: Config) -> Subjective:
    """The book's model with the configured numbers."""
    area = config.map
    # Dempster-Shafer's masses (11.7, 11.8) are those of the consistent form, whatever Bayes believes.
    printed = area.model == "murphy" and area.theory == "bayes"
    return Subjective(Form.PRINTED if printed else Form.CONSISTENT, area.max_occupied)


def verifier(config: Config) -> Verifier | Believer:
    """What a reading must pass; each map has its own."""
    return Verifier(config.firing.agreement_m) if config.firing.verifies else Believer()


def geometry(config: Config) -> GridGeometry:
    """The configured map area, its middle at the start of the run. Raises ConfigError without its size."""
    width, height = config.map.width_m, config.map.height_m
    if width is None or height is None:
        raise ConfigError([(("map",), "a run needs `width_m` and `height_m`")])
    return centred(Pose(), width, height, config.map.resolution_m)


def centred(middle: Pose, width: float, height: float, resolution: float) -> GridGeometry:
    """An area (m) around a point. Raises UsageError when it has more cells than a map may have."""
    west, south = middle.x - width / 2.0, middle.y - height / 2.0
    return bounded(west, south, west + width, south + height, resolution)


def bounded(west: float, south: float, east: float, north: float, resolution: float) -> GridGeometry:
    """A map over a box (m). Raises UsageError when it has more cells than a map may have."""
    cells = (east - west) / resolution * ((north - south) / resolution)
    if not cells <= MOST_CELLS:
        size = f"{east - west:.6g} m x {north - south:.6g} m at {resolution} m"
        mend = "give [map] `width_m` and `height_m`, or a coarser resolution"
        raise UsageError([f"a map of {size} has {cells:.2g} cells, more than {MOST_CELLS:.0e}: {mend}"])
    return GridGeometry.covering(west, south, east, north, resolution)


def pose_gap_ns(config: Config) -> int:
    """The widest gap between poses that is interpolated."""
    return round(config.map.pose_gap_s * SECOND_NS)


def drive(config: Config) -> Drive:
    """What the wheels say of the robot's motion. Raises ConfigError without the wheels' measures."""
    robot = config.robot
    if robot.drive == "differential":
        return differential(config, "wheel odometry")
    if robot.wheel_radius_m is None or robot.wheelbase_m is None:
        raise ConfigError([(("robot",), "`wheel_radius_m` and `wheelbase_m` are needed for wheel odometry")])
    kind = Tricycle if robot.drive == "tricycle" else Ackermann
    spread, steering_spread = (robot.wheel_error_mm * 1e-3) ** 2, radians(robot.steering_error_deg) ** 2
    return kind(robot.wheel_radius_m, robot.wheelbase_m, spread, steering_spread)


def differential(config: Config, purpose: str) -> Differential:
    """The same of a differential drive. Raises ConfigError for another one, with what it is needed for."""
    robot = config.robot
    if robot.drive != "differential":
        found = f'`drive` is "{robot.drive}": {purpose} needs a differential one'
        raise ConfigError([(("robot", "drive"), found)])
    if robot.wheel_radius_m is None or robot.track_m is None:
        raise ConfigError([(("robot",), "`wheel_radius_m` and `track_m` are needed for wheel odometry")])
    left = robot.wheel_radius_m * 2.0 / (robot.wheel_ratio + 1.0)
    right = robot.wheel_radius_m * 2.0 / (1.0 / robot.wheel_ratio + 1.0)
    spread = (robot.wheel_error_mm * 1e-3) ** 2
    return skid_steer(Differential(left, right, robot.track_m, spread), robot.slip_factor)


def odometry(config: Config) -> Odometry:
    """Dead reckoning, with the gyro if there is one. Raises ConfigError without the wheels' measures."""
    gyros = [YawFusion(Gyro(), radians(gyro.turn_error_deg) ** 2) for gyro in config.gyro]
    return Odometry(drive(config), gyros[0] if gyros else None)
