"""echogrid read: what one device says, live."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_directory, add_settings, count, duration

if TYPE_CHECKING:
    from echogrid.drivers.device import State
    from echogrid.drivers.readings import Reading
    from echogrid.runtime.acquisition import DeviceReport
    from echogrid.runtime.commands.arguments import Commands
    from echogrid.runtime.config import Config
    from echogrid.runtime.lone_bus import LoneBus

_LOOK_S = 0.2
"""How often the device's health is looked at."""
_PAUSE_NS = 1_000_000_000
"""Texts that take turns are no news."""


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser("read", help="show what one device says", description=__doc__)
    parser.add_argument(
        "device",
        metavar="DEVICE",
        help="the name of a [[sensor]], [[wheel]] or [[gyro]] in robot.toml; with --port, of a driver",
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

    clock, news, lines = MonotonicClock(), HealthNews(), _Lines(arguments.json)
    start_ns, shown = clock.now_ns(), 0
    until_s = arguments.duration or float("inf")
    while (elapsed_s := (clock.now_ns() - start_ns) * 1e-9) < until_s and shown != arguments.count:
        bus.turn_until(lambda: bus.waiting > 0, min(_LOOK_S, until_s - elapsed_s))
        readings = bus.take()[: None if arguments.count is None else arguments.count - shown]
        shown += len(readings)
        lines.show(readings)
        (report,) = device_reports([bus.pump], clock.now_ns())
        if line := news.line(report, clock.now_ns()):
            print(line, file=sys.stderr, flush=True)
    return 0 if shown else 1


class HealthNews:
    """Which changes of a device's health are told: a new state at once, none more than once a second."""

    def __init__(self) -> None:
        self._said = ""
        self._told_ns: dict[State, int] = {}

    def line(self, report: "DeviceReport", now_ns: int) -> str | None:
        """What is to be told now, if anything is."""
        health = report.health
        said = f"{report.device}: {health.state.value}: {health.message}"
        told_ns = self._told_ns.get(health.state)
        if said == self._said or (told_ns is not None and now_ns - told_ns < _PAUSE_NS):
            return None
        self._said, self._told_ns[health.state] = said, now_ns
        return said


class _Lines:
    """Readings on stdout. Times count from the first: what comes unasked was measured before it is read."""

    def __init__(self, as_json: bool) -> None:
        self._as_json = as_json
        self._first_ns: int | None = None

    def show(self, readings: "Sequence[Reading]") -> None:
        """Print them."""
        from echogrid.runtime.reading_text import as_line, as_object

        for reading in readings:
            if self._first_ns is None:
                self._first_ns = reading.stamp_ns
            text = json.dumps(as_object(reading)) if self._as_json else as_line(reading, self._first_ns)
            print(text, flush=True)
