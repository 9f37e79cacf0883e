"""One device by itself: of a configured robot, or on a port that is named."""

from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from echogrid.drivers import registry
from echogrid.drivers.clock import Clock
from echogrid.drivers.errors import UnknownDriverError
from echogrid.drivers.yaw_gyro import is_for_gyros
from echogrid.runtime.config import Config
from echogrid.runtime.errors import ConfigError, UsageError, described
from echogrid.runtime.hardware_config import BusConfig, GyroConfig, SensorConfig, WheelConfig
from echogrid.runtime.lines import line_of
from echogrid.runtime.lone_bus import LoneBus, lone_bus
from echogrid.runtime.ports import real_ports
from echogrid.runtime.toml_values import nearest

FARTHEST_M = 4.0
"""The reach that is asked of a ranger of which nothing else is known."""
LEAST_M = 1.0
"""And of one which can't hear so far."""
_BUS = "port"


def alone(config: Config, name: str) -> Config:
    """The configuration less all devices but that one. Raises UsageError if there is none of that name."""
    sensors = tuple(sensor for sensor in config.sensor if sensor.name == name)
    wheels = tuple(wheel for wheel in config.wheel if wheel.name == name)
    gyros = tuple(gyro for gyro in config.gyro if gyro.name == name)
    if not sensors and not wheels and not gyros:
        known = [each.name for entries in (config.sensor, config.wheel, config.gyro) for each in entries]
        raise UsageError([f"no [[sensor]], [[wheel]] or [[gyro]] named {name!r}{nearest(name, known)}"])
    return Config(config.robot, config.bus, sensors, wheels, gyro=gyros)


def on_port(driver: str, port: str, settings: Mapping[str, Any]) -> Config:
    """The configuration of a robot with nothing but a device of that driver on that port.

    Raises UsageError if there is no such driver.
    """
    try:
        found = registry.driver(driver)
        kind = found.bus
    except UnknownDriverError as error:
        raise UsageError([str(error)]) from error
    interface = "slcan" if Path(port).is_char_device() else "socketcan"
    bus = BusConfig(_BUS, kind, port, interface)  # type: ignore[arg-type]  # drivers' kinds are the ports'
    if is_for_gyros(found):
        return Config(bus=(bus,), gyro=(GyroConfig(driver, driver, _BUS, settings=settings),))
    if kind == "can":
        return Config(bus=(bus,), wheel=(WheelConfig("left", driver, _BUS, settings=settings),))
    for farthest in (FARTHEST_M, LEAST_M):
        sensor = SensorConfig(driver, 0.0, 0.0, 0.0, 15.0, 0.0, farthest, driver, _BUS, settings)
        config = Config(bus=(bus,), sensor=(sensor,))
        try:
            line_of(config)
        except ConfigError as error:
            if farthest == LEAST_M or "max_m" not in str(error):
                raise UsageError([described(place[2:], what) for place, what in error.found]) from error
        else:
            break
    return config


def opened(config: Config, folder: Path, clock: Clock) -> AbstractContextManager[LoneBus]:
    """The bus of the configuration's only device, open. Raises ConfigError, PortError."""
    line = line_of(config)
    return lone_bus(line, real_ports(config, [line], folder)[line.name], clock)
