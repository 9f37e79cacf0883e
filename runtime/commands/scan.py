"""echogrid scan: which rangers hang on which ports."""

import argparse
import json
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from echogrid.runtime.commands.arguments import Commands
    from echogrid.runtime.scan import Found


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser(
        "scan",
        help="find rangers on the machine's ports",
        description=f"{__doc__} It reads the registers of I2C chips and listens on serial lines, and changes "
        "nothing. With --ask it also lets what it finds ping, and talks to serial rangers which are silent "
        "until they are spoken to.",
    )
    parser.add_argument(
        "ports",
        nargs="*",
        metavar="PORT",
        help="such as /dev/i2c-1, /dev/ttyUSB0, unix:PATH (default: all of the machine's)",
    )
    parser.add_argument("--ask", action="store_true", help="also send commands, so that devices ping")
    parser.add_argument("--json", action="store_true", help="one JSON object a line")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Print what is found; the exit code: 1 if that is nothing."""
    from echogrid.drivers.clock import MonotonicClock
    from echogrid.drivers.errors import PortError
    from echogrid.runtime import scan

    ports = arguments.ports or scan.machine_ports()
    if not ports:
        print(
            "echogrid scan: this machine has no I2C bus and no serial port (sudo modprobe i2c-dev?)",
            file=sys.stderr,
        )
    total = 0

    def tell(line: str) -> None:
        print(f"  {line}", file=sys.stderr, flush=True)

    for port in ports:
        if not arguments.json:
            print(port, flush=True)
        try:
            for found in scan.scan(port, arguments.ask, MonotonicClock(), tell):
                total += 1
                print(_object(found) if arguments.json else _line(found), flush=True)
        except PortError as error:
            print(error, file=sys.stderr)
    return 0 if total else 1


def _line(found: "Found") -> str:
    address = "" if found.address is None else f"{found.address:#04x}  "
    likely = [f"{key} {value}?" for key, value in found.settings.items() if key != "address"]
    drivers = " or ".join(found.drivers) or "an unknown device"
    return f"  {address}{drivers}{''.join(f' ({each})' for each in likely)}  {found.reading}".rstrip()


def _object(found: "Found") -> str:
    return json.dumps(
        {
            "port": found.port,
            "drivers": list(found.drivers),
            "address": found.address,
            "settings": found.settings,
            "reading": found.reading or None,
        }
    )
