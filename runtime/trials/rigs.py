"""The robots that are tried: their outline, their motors, and which ranger fires when."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import cos, degrees, pi, radians, sin

from echogrid.emulation import hearing
from echogrid.emulation.acoustics import Transducer
from echogrid.emulation.body import Body, Disc, Hull
from echogrid.emulation.plant import Drive
from echogrid.emulation.transducers import POLAROID, TRANSDUCERS
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.unknown import Unknown
from echogrid.runtime.config import Config, DriveConfig, LocalConfig
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.firing_groups import grouped
from echogrid.runtime.hardware_config import RobotConfig, SensorConfig
from echogrid.runtime.hull import footprint
from echogrid.runtime.obstacle_config import AvoidConfig, ObstacleConfig
from echogrid.runtime.robot_file import load

_MILLISECOND_NS = 1_000_000
_GAP_NS = 35 * _MILLISECOND_NS
"""Of a ring: from one group to the next; 4 m and back, and 12 ms in which it dies away."""
_REACH_M = 4.0
_NEAREST_M = 0.15
_SENSORS_AT_M = 0.08
"""From the middle: set back, so that their blanking distance ends at the robot's rim."""
_RADIUS_M = 0.22
_CORNERS = 36
"""Of the outline that stands for the round robot; it lies outside the circle."""
_STOPS_AT_M = 0.1
"""From the rim: half a metre, the default, would hold it in doors."""
_SEPARATION = radians(90.0)
_UNASKED_NS = 100 * _MILLISECOND_NS
"""How often an A02YYUW sends."""


@dataclass(frozen=True, slots=True)
class Seat:
    """A ranger on the robot, as the emulator and as the map see it, and when it fires."""

    heard: hearing.Ranger
    ranger: Ranger
    first_ns: int
    every_ns: int
    lag_ns: int = 0
    """From the end of its listening until its reading is there."""


@dataclass(frozen=True, slots=True)
class Rig:
    """A robot."""

    name: str
    body: Body
    seats: tuple[Seat, ...]
    """Counter-clockwise: neighbours are adjacent, the last and the first too."""
    config: Config
    """What its robot.toml says, if it has one: of a ring without buses and drivers."""
    drive: Drive = field(default_factory=Drive)


def _ring(count: int) -> Rig:
    """Polaroids of +-15 deg all around; each group of four looks into four directions."""
    bearings = [2.0 * pi * index / count for index in range(count)]
    groups = grouped(bearings, _SEPARATION)
    turns = {index: turn for turn, group in enumerate(groups) for index in group}
    transducer = replace(POLAROID, reach=_REACH_M)

    sensors = tuple(_on_ring(index, bearing) for index, bearing in enumerate(bearings))
    seats = tuple(
        _seat(sensor.ranger(), transducer, turns[index] * _GAP_NS, len(groups) * _GAP_NS)
        for index, sensor in enumerate(sensors)
    )
    motors = Drive()
    config = Config(
        RobotConfig(f"ring-{count}", motors.wheel_radius, motors.track, footprint=_round(_RADIUS_M)),
        sensor=sensors,
        drive=DriveConfig(motors.speed, degrees(motors.turn_rate), motors.acceleration),
        local=LocalConfig(resolution_m=0.05),
        obstacle=ObstacleConfig(stop_distance_m=_STOPS_AT_M),
        avoid=AvoidConfig(unknown=Unknown.SLOW, deceleration_mps2=motors.acceleration),
    )
    return Rig(f"ring-{count}", Disc(_RADIUS_M), seats, config, motors)


def _on_ring(index: int, bearing: float) -> SensorConfig:
    x, y = _SENSORS_AT_M * cos(bearing), _SENSORS_AT_M * sin(bearing)
    return SensorConfig(f"ring_{index}", x, y, degrees(bearing), 15.0, _NEAREST_M, _REACH_M)


def _round(radius: float) -> tuple[tuple[float, ...], ...]:
    """Corners around a disc."""
    outer = radius / cos(pi / _CORNERS)
    around = [2.0 * pi * (k + 0.5) / _CORNERS for k in range(_CORNERS)]
    return tuple((outer * cos(angle), outer * sin(angle)) for angle in around)


def _built_in() -> Rig:
    """The robot that `echogrid run` drives; its SRF08 are heard without their chips' gain ramp."""
    config = load(DEFAULT_ROBOT)
    turns = {name: turn for turn, group in enumerate(config.firing.groups) for name in group}
    gap_ns = round((config.firing.gap_ms or 0.0) * _MILLISECOND_NS)
    seats = tuple(_configured(config, index, turns, gap_ns) for index in _around(config))
    limits = config.drive
    motors = Drive(limits.max_speed_mps, limits.acceleration_mps2, radians(limits.max_turn_dps))
    return Rig("built-in", Hull(footprint(config).corners), seats, config, motors)


def _around(config: Config) -> list[int]:
    """The sensors' numbers, counter-clockwise."""
    return sorted(range(len(config.sensor)), key=lambda index: config.sensor[index].yaw_deg % 360.0)


def _configured(config: Config, index: int, turns: Mapping[str, int], gap_ns: int) -> Seat:
    sensor = config.sensor[index]
    transducer = TRANSDUCERS[sensor.driver or ""]
    if sensor.name in turns:
        cycle_ns = len(config.firing.groups) * gap_ns
        return _seat(sensor.ranger(), transducer, turns[sensor.name] * gap_ns, cycle_ns)
    lag_ns = round(float(sensor.settings.get("lag_ms", 0.0)) * _MILLISECOND_NS)
    seat = _seat(sensor.ranger(), transducer, index * 7 * _MILLISECOND_NS, _UNASKED_NS)
    return replace(seat, lag_ns=lag_ns)


def _seat(ranger: Ranger, transducer: Transducer, first_ns: int, every_ns: int) -> Seat:
    mount = ranger.mount
    heard = hearing.Ranger(ranger.name, (mount.x, mount.y, mount.yaw), transducer)
    return Seat(heard, ranger, first_ns, every_ns)


RIGS: Mapping[str, Callable[[], Rig]] = {
    "ring-16": lambda: _ring(16),
    "ring-12": lambda: _ring(12),
    "built-in": _built_in,
}
