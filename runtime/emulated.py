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
from echogrid.emulation.models import RANGERS, WHEELS, Model
from echogrid.emulation.motion import Tour
from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RangerSpec, RobotSpec, WheelSpec
from echogrid.emulation.transducers import TRANSDUCERS
from echogrid.emulation.world import World
from echogrid.runtime import assembly
from echogrid.runtime.config import Config, SensorConfig, WheelConfig
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.lines import lines
from echogrid.runtime.toml_values import Problem

DEFAULT_ROBOT = Path(__file__).with_name("emulated_robot.toml")

_SECOND_NS = 1_000_000_000


def emulated_robot(
    config: Config,
    started_ns: int,
    seed: int,
    world: World | None = None,
    tour: Tour | None = None,
    *,
    driven: bool = False,
) -> EmulatedRobot:
    """A robot of that configuration, driving its tour through the office since `started_ns`.

    `driven`: it stands at the start of the tour, and goes where its motors turn its wheels. Raises
    ConfigError, RobotSpecError when something in it can't be emulated.
    """
    lines(config)
    spec, wheels = robot_spec(config), assembly.drive(config)
    place, way = world or office(), tour or office_tour()

    base = DrivenBase(way.pose(0.0), started_ns, (wheels.left_radius, wheels.right_radius), wheels.track)

    def pose_at(now_ns: int) -> tuple[float, float, float]:
        return base.pose(now_ns) if driven else way.pose((now_ns - started_ns) / _SECOND_NS)

    air = Air(Outing(place, pose_at, seed, started_ns))

    def surroundings_of(ranger: RangerSpec) -> Surroundings:
        mount = (ranger.x, ranger.y, ranger.yaw)
        return air.surroundings(Ranger(ranger.name, mount, TRANSDUCERS[ranger.model]))

    def wheel_angle(side: str, now_ns: int) -> float:
        left, right = way.wheel_angles((now_ns - started_ns) / _SECOND_NS, 1.0, wheels.track)
        return left / wheels.left_radius if side == "left" else right / wheels.right_radius

    def shaft_of(side: str) -> Callable[[int], float]:
        if driven:
            return base.left if side == "left" else base.right
        return partial(wheel_angle, side)

    return EmulatedRobot(spec, surroundings_of, shaft_of, seed=seed)


def robot_spec(config: Config) -> RobotSpec:
    """What the emulator must be told. Raises ConfigError when something in it can't be emulated."""
    radius, track = config.robot.wheel_radius_m, config.robot.track_m
    entries: list[tuple[str, int, str | None, Mapping[str, object]]] = [
        *(("sensor", index, sensor.driver, RANGERS) for index, sensor in enumerate(config.sensor)),
        *(("wheel", index, wheel.driver, WHEELS) for index, wheel in enumerate(config.wheel)),
    ]
    problems: list[Problem] = [
        ((kind, index, "driver"), f"{driver!r} has no emulator (there are: {', '.join(sorted(models))})")
        for kind, index, driver, models in entries
        if driver not in models
    ]
    if radius is None or track is None:
        problems.append((("robot",), "`wheel_radius_m` and `track_m` are needed to drive"))
    if problems or radius is None or track is None:
        raise ConfigError(problems)
    return RobotSpec(
        radius,
        track,
        tuple(BusSpec(bus.name, bus.kind, bus.bit_rate) for bus in config.bus),
        tuple(_ranger(sensor) for sensor in config.sensor),
        tuple(_wheel(wheel) for wheel in config.wheel),
    )


def _ranger(sensor: SensorConfig) -> RangerSpec:
    driver, bus = sensor.driver or "", sensor.bus or ""
    options = _shared(sensor, RANGERS[driver])
    return RangerSpec(sensor.name, driver, bus, sensor.x_m, sensor.y_m, radians(sensor.yaw_deg), options)


def _wheel(wheel: WheelConfig) -> WheelSpec:
    options = {"gear": wheel.gear, **_shared(wheel, WHEELS[wheel.driver])}
    return WheelSpec(wheel.name, wheel.driver, wheel.bus, wheel.name, options)


def _shared(entry: SensorConfig | WheelConfig, model: Model[Any]) -> dict[str, int | float]:
    """The settings which the device shares with its driver: its address, its node."""
    known = {option.name for option in fields(model.options)}
    return {key: value for key, value in entry.settings.items() if key in known}
