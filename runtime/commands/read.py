"""echogrid read: what one device says, live."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_directory, add_settings, count, duration

if TYPE_CHECKING:
    from echogrid.drivers.readings import Reading
    from echogrid.runtime.commands.arguments import Commands
    from echogrid.runtime.config import Config
    from echogrid.runtime.lone_bus import LoneBus

_LOOK_S = 0.2
"""How often the device's health is looked at."""


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser("read", help="show what one device says", description=__doc__)
    parser.add_argument(
        "device",
        metavar="DEVICE",
        help="the name of a [[sensor]] or [[wheel]] in robot.toml; with --port, the name of a driver",
    )
    parser.add_argument(
        "--robot", type=Path, metavar="robot.toml", help="which robot (default: the emulated one, if it runs)"
    )
    parser.add_argument("--port", metavar="PORT", help="such as /dev/ttyUSB0 or /dev/i2c-1")
    add_settings(parser, "with --port: a key of the driver, such as address=0x71")
    parser.add_argument("--count", type=count, metavar="N", help="end after so many readings")
    parser.add_argument("--duration", type=duration, metavar="TIME", help="end after so long, such as 10s")
    parser.add_argument("--json", action="store_true", help="one JSON object a line")
    add_directory(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Show the readings until it is enough; the exit code: 1 if there were none."""
    from echogrid.drivers.clock import MonotonicClock
    from echogrid.runtime import lone_device, robot_file
    from echogrid.runtime.errors import UsageError

    if arguments.port is not None:
        config = lone_device.on_port(arguments.device, arguments.port, dict(arguments.settings))
        with lone_device.opened(config, Path(), MonotonicClock()) as bus:
            return _show(bus, arguments)
    if arguments.settings:
        raise UsageError(["echogrid read: --set goes with --port (robot.toml has the keys otherwise)"])
    source = arguments.robot or arguments.dir / "robot.toml"
    config = lone_device.alone(_robot(source, arguments), arguments.device)
    with robot_file.located(source), lone_device.opened(config, source.parent, MonotonicClock()) as bus:
        return _show(bus, arguments)


def _robot(source: Path, arguments: argparse.Namespace) -> "Config":
    from echogrid.runtime import robot_file
    from echogrid.runtime.errors import UsageError

    if arguments.robot is None and not source.exists():
        mend = "give --robot or --port, or start one with: echogrid emulate"
        raise UsageError([f"echogrid read: no emulated robot runs in {arguments.dir} ({mend})"])
    return robot_file.load(source)


def _show(bus: "LoneBus", arguments: argparse.Namespace) -> int:
    from echogrid.drivers.clock import MonotonicClock
    from echogrid.runtime.acquisition import device_reports

    clock = MonotonicClock()
    start_ns, shown, health = clock.now_ns(), 0, ""
    until_s = arguments.duration or float("inf")
    while (elapsed_s := (clock.now_ns() - start_ns) * 1e-9) < until_s and shown != arguments.count:
        bus.turn_until(lambda: bus.waiting > 0, min(_LOOK_S, until_s - elapsed_s))
        readings = bus.take()[: None if arguments.count is None else arguments.count - shown]
        shown += len(readings)
        _print(readings, start_ns, arguments.json)
        (report,) = device_reports([bus.pump], clock.now_ns())
        said = f"{report.device}: {report.health.state.value}: {report.health.message}"
        if said != health:
            print(said, file=sys.stderr, flush=True)
            health = said
    return 0 if shown else 1


def _print(readings: "Sequence[Reading]", start_ns: int, as_json: bool) -> None:
    from echogrid.runtime.reading_text import as_line, as_object

    for reading in readings:
        text = json.dumps(as_object(reading)) if as_json else as_line(reading, start_ns)
        print(text, flush=True)
