"""echogrid emulate: the emulated robot as a process of its own, on real ports."""

import argparse
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_directory, add_seed
from echogrid.runtime.errors import UsageError

if TYPE_CHECKING:
    from echogrid.runtime.commands.arguments import Commands

_MARK = "# A copy, which goes when the emulated robot does.\n"


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser("emulate", help="run the emulated robot", description=__doc__)
    parser.add_argument(
        "robot", type=Path, nargs="?", metavar="robot.toml", help="which robot (default: the built-in one)"
    )
    parser.add_argument(
        "--driven", action="store_true", help="it stands until its motors are commanded, instead of touring"
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

    stop = _Asked()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, stop.ask)
    source = arguments.robot or DEFAULT_ROBOT
    config = robot_file.load(source)
    clock = MonotonicClock()
    with robot_file.located(source):
        robot = emulated_robot(config, clock.now_ns(), arguments.seed, driven=arguments.driven)
    with Server(robot, arguments.dir, clock) as server, _described(source, arguments.dir) as robot_toml:
        told = f"the emulated robot is in {arguments.dir}; read it with: echogrid run {robot_toml}"
        print(told, file=sys.stderr, flush=True)
        server.run(stop)
    return 0


class _Asked:
    """Set by signals. Not a threading.Event: a signal that comes while one is being set would lock it up."""

    def __init__(self) -> None:
        self._asked = False

    def ask(self, *_: object) -> None:
        """Take note of a signal."""
        self._asked = True

    def is_set(self) -> bool:
        """Whether one came."""
        return self._asked


@contextmanager
def _described(source: Path, directory: Path) -> Iterator[Path]:
    """A copy of the robot's description beside its ports, while the context lasts. A description of the
    user's own is left alone; one which a dead emulator left is not."""
    copy = directory / "robot.toml"
    if copy.exists() and not copy.read_text(encoding="utf-8").startswith(_MARK):
        if not copy.samefile(source):
            raise UsageError([f"{copy}: is in the way (move it, or choose another --dir)"])
        yield copy
        return
    text = source.read_text(encoding="utf-8").removeprefix(_MARK)
    copy.write_text(_MARK + text, encoding="utf-8")
    try:
        yield copy
    finally:
        copy.unlink(missing_ok=True)
