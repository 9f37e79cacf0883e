"""echogrid emulate: the emulated robot as a process of its own, on real ports."""

import argparse
import signal
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_directory, add_seed

if TYPE_CHECKING:
    from echogrid.runtime.commands.arguments import Commands


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser("emulate", help="run the emulated robot", description=__doc__)
    parser.add_argument(
        "robot", type=Path, nargs="?", metavar="robot.toml", help="which robot (default: the built-in one)"
    )
    add_directory(parser)
    add_seed(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Serve until interrupted; the exit code."""
    from echogrid.drivers.clock import MonotonicClock
    from echogrid.emulation.server import Server
    from echogrid.runtime import robot_file
    from echogrid.runtime.emulated import DEFAULT_ROBOT, emulated_robot

    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    source = arguments.robot or DEFAULT_ROBOT
    config = robot_file.load(source)
    clock = MonotonicClock()
    robot = emulated_robot(config, clock.now_ns(), arguments.seed)
    with Server(robot, arguments.dir, clock) as server:
        copy = arguments.dir / "robot.toml"
        copy.write_text(source.read_text(encoding="utf-8"), encoding="utf-8")
        print(f"the emulated robot is in {arguments.dir}; read it with: echogrid run {copy}", file=sys.stderr)
        server.run(stop)
        copy.unlink(missing_ok=True)
    return 0
