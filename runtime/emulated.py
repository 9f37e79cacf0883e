"""The emulated counterpart of a configured robot: same buses, same devices, in an office."""

from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import partial
from math import radians
from pathlib import Path
from typing import Any

from echogrid.emulation.air import Air
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.driven import DrivenBase
from echogrid.emulation.hearing import Outing, Ranger
from echogrid.emulation.models import GYROS, RANGERS, WHEELS, Model
from echogrid.emulation.motion import Tour
from echogrid.emulation.offices import office, office_circuit, office_tour
from echogrid.emulation.robot import BusSpec, EmulatedRobot, GyroSpec, RangerSpec, RobotSpec, WheelSpec
from echogrid.emulation.round import Round
from echogrid.emulation.transducers import TRANSDUCERS
from echogrid.emulation.world import World
from echogrid.mapping.kinematics import Ackermann, Differential
from echogrid.runtime import assembly
from echogrid.runtime.config import Config
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.hardware_config import GyroConfig, SensorConfig, WheelConfig
from echogrid.runtime.lines import lines
from echogrid.runtime.toml_values import Problem

DEFAULT_ROBOT = Path(__file__).with_name("emulated_robot.toml")

_SECOND_NS = 1_000_000_000
_SLOPE_NS = 2_000_000
"""The yaw rate is the mean over so long."""
_STEERING_S = 1.0
"""For so long a tricycle stands between lines and turns, to turn its steering."""


def emulated_robot(
    config: Config,
    started_ns: int,
    seed: int,
    world: World | None = None,
    tour: Round | None = None,
    *,
    driven: bool = False,
) -> EmulatedRobot:
    """A robot of that configuration, driving its tour through the office since `started_ns`.

    `driven`: it stands at the start of the tour, and goes where its motors turn its wheels. Raises
    ConfigError, RobotSpecError when something in it can't be emulated.
    """
    lines(config)
    spec, drive = robot_spec(config), assembly.drive(config)
    place, way = world or office(), tour or office_round(config)
    if isinstance(drive, Ackermann) and isinstance(way, Tour):
        raise ConfigError([(("robot", "drive"), "an Ackermann can't turn in place: give it a Circuit")])
    base = _driven_base(config, way, started_ns) if driven else None

    def pose_at(now_ns: int) -> tuple[float, float, float]:
        return base.pose(now_ns) if base else way.pose((now_ns - started_ns) / _SECOND_NS)

    def yaw_rate(now_ns: int) -> float:
        return (pose_at(now_ns)[2] - pose_at(now_ns - _SLOPE_NS)[2]) / _SLOPE_NS * _SECOND_NS

    zeros: dict[str, float] = {wheel.name: radians(wheel.zero_deg) for wheel in config.wheel}

    def shaft_angle(side: str, now_ns: int) -> float:
        return zeros[side] + _wheel_angle(drive, way, side, (now_ns - started_ns) / _SECOND_NS)

    def shaft_of(side: str) -> Callable[[int], float]:
        if base:
            return base.left if side == "left" else base.right
        return partial(shaft_angle, side)

    around = surroundings(Outing(place, pose_at, seed, started_ns))
    return EmulatedRobot(spec, around, shaft_of, yaw_rate=yaw_rate, seed=seed)


def surroundings(outing: Outing) -> Callable[[RangerSpec], Surroundings]:
    """What each ranger of a robot on its way has around it; all share the air."""
    air = Air(outing)

    def around(ranger: RangerSpec) -> Surroundings:
        mount = (ranger.x, ranger.y, ranger.yaw)
        return air.surroundings(Ranger(ranger.name, mount, TRANSDUCERS[ranger.model]))

    return around


def office_round(config: Config) -> Round:
    """The round through the office that such a robot can drive."""
    if config.robot.drive == "ackermann":
        return office_circuit()
    return office_tour(pause=_STEERING_S if config.robot.wheels.steered else 0.0)


def _driven_base(config: Config, way: Round, started_ns: int) -> DrivenBase:
    wheels = assembly.differential(config, "driving by command")
    return DrivenBase(way.pose(0.0), started_ns, (wheels.left_radius, wheels.right_radius), wheels.track)


def _wheel_angle(drive: assembly.Drive, way: Round, wheel: str, t_s: float) -> float:
    """rad: how far that wheel has turned then; how far it is turned, if it steers."""
    if isinstance(drive, Differential):
        left, right = way.wheel_angles(t_s, 1.0, drive.track)
        return left / drive.left_radius if wheel == "left" else right / drive.right_radius
    if wheel == drive.wheels.second:
        return way.steering(t_s, drive.wheelbase)
    rolled = way.distance(t_s) if isinstance(drive, Ackermann) else way.rolled(t_s, drive.wheelbase)
    return rolled / drive.radius


def robot_spec(config: Config) -> RobotSpec:
    """What the emulator must be told. Raises ConfigError when something in it can't be emulated."""
    robot = config.robot
    key = "wheelbase_m" if robot.wheels.steered else "track_m"
    radius, apart = robot.wheel_radius_m, getattr(robot, key)
    entries: list[tuple[str, int, str | None, Mapping[str, object]]] = [
        *(("sensor", index, sensor.driver, RANGERS) for index, sensor in enumerate(config.sensor)),
        *(("wheel", index, wheel.driver, WHEELS) for index, wheel in enumerate(config.wheel)),
        *(("gyro", index, gyro.driver, GYROS) for index, gyro in enumerate(config.gyro)),
    ]
    problems: list[Problem] = [
        ((kind, index, "driver"), f"{driver!r} has no emulator (there are: {', '.join(sorted(models))})")
        for kind, index, driver, models in entries
        if driver not in models
    ]
    if radius is None or apart is None:
        problems.append((("robot",), f"`wheel_radius_m` and `{key}` are needed to drive"))
    if problems or radius is None or apart is None:
        raise ConfigError(problems)
    return RobotSpec(
        radius,
        apart,
        tuple(BusSpec(bus.name, bus.kind, bus.bit_rate) for bus in config.bus),
        tuple(_ranger(sensor) for sensor in config.sensor),
        tuple(_wheel(wheel) for wheel in config.wheel),
        tuple(_gyro(gyro) for gyro in config.gyro),
    )


def _ranger(sensor: SensorConfig) -> RangerSpec:
    driver, bus = sensor.driver or "", sensor.bus or ""
    options = _shared(sensor, RANGERS[driver])
    return RangerSpec(sensor.name, driver, bus, sensor.x_m, sensor.y_m, radians(sensor.yaw_deg), options)


def _wheel(wheel: WheelConfig) -> WheelSpec:
    options = {"gear": wheel.gear, **_shared(wheel, WHEELS[wheel.driver])}
    return WheelSpec(wheel.name, wheel.driver, wheel.bus, wheel.name, options)


def _gyro(gyro: GyroConfig) -> GyroSpec:
    return GyroSpec(gyro.name, gyro.driver, gyro.bus, _shared(gyro, GYROS[gyro.driver]))


def _shared(entry: SensorConfig | WheelConfig | GyroConfig, model: Model[Any]) -> dict[str, int | float]:
    """The settings which the device shares with its driver: its address, its node."""
    known = {option.name for option in fields(model.options)}
    return {key: value for key, value in entry.settings.items() if key in known}
