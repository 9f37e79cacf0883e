"""The real ports of a configured robot."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from echogrid.drivers.bus import Port
from echogrid.drivers.device import BusLine
from echogrid.drivers.transports.ports import make_port
from echogrid.runtime.config import Config
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.hardware_config import BusConfig
from echogrid.runtime.toml_values import Problem

_SOCKET = "unix:"
_PATH_INTERFACES = ("slcan",)
"""python-can interfaces whose channel is a path."""


def real_ports(config: Config, lines: list[BusLine[Any, Any]], folder: Path) -> dict[str, Port[Any, Any]]:
    """The port of each line, not yet open; relative paths start at `folder`. Raises ConfigError."""
    buses = {bus.name: bus for bus in config.bus}
    ports: dict[str, Port[Any, Any]] = {}
    places = {bus.name: ("bus", index) for index, bus in enumerate(config.bus)}
    problems: list[Problem] = []
    for line in lines:
        bus = buses[line.name]
        try:
            ports[line.name] = make_port(bus.kind, _address(bus, folder), _options(bus, line))
        except ValueError as error:
            problems.append((places[bus.name], str(error)))
    if problems:
        raise ConfigError(problems)
    return ports


def _address(bus: BusConfig, folder: Path) -> str:
    if bus.kind == "can" and bus.interface not in _PATH_INTERFACES:
        return bus.port
    if bus.port.startswith(_SOCKET):
        return f"{_SOCKET}{folder / bus.port.removeprefix(_SOCKET)}"
    return str(folder / bus.port)


def _options(bus: BusConfig, line: BusLine[Any, Any]) -> Mapping[str, Any]:
    """What the devices want of their port, and what the configuration says instead."""
    wanted: dict[str, Any] = {}
    for device in line.devices:
        wanted |= device.port_options
    if bus.kind == "serial" and bus.bit_rate is not None:
        wanted["baud"] = bus.bit_rate
    if bus.kind == "can":
        wanted["interface"] = bus.interface
        if bus.listen_only:
            wanted["listen_only"] = True
        if bus.bit_rate is not None:
            wanted["bitrate"] = bus.bit_rate
    return wanted
