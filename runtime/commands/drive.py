"""echogrid drive: let the wheels turn for a while, to see that they go the right way."""

import argparse
import signal
import sys
from math import degrees, radians
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_directory, duration, finite

if TYPE_CHECKING:
    from echogrid.mapping.pose import Pose
    from echogrid.runtime.commands.arguments import Commands
    from echogrid.runtime.excursion import Excursion, Stage

_SECOND_NS = 1_000_000_000


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser(
        "drive",
        help="let the wheels turn",
        description=f"{__doc__} Nothing watches for obstacles: lift the wheels, or clear the floor.",
    )
    parser.add_argument(
        "--robot", type=Path, metavar="robot.toml", help="which robot (default: the emulated one, if it runs)"
    )
    parser.add_argument("--forward", type=finite, default=0.0, metavar="M/S", help="speed ahead")
    parser.add_argument("--turn", type=finite, default=0.0, metavar="DEG/S", help="counter-clockwise")
    parser.add_argument(
        "--for", dest="lasts", type=duration, required=True, metavar="TIME", help="such as 2s"
    )
    add_directory(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Drive until the time is over, or something is wrong; the exit code: 1 if it ended early."""
    from echogrid.runtime import robot_file
    from echogrid.runtime.drive_run import driven
    from echogrid.runtime.excursion import Wanted

    source = arguments.robot or arguments.dir / "robot.toml"
    config = robot_file.load(source)
    wanted = Wanted(arguments.forward, radians(arguments.turn), round(arguments.lasts * _SECOND_NS))
    with robot_file.located(source), driven(config, source.parent, wanted) as run:
        _stop_on_signals(run.excursion)
        run.go(_show)
    if run.excursion.trouble:
        print(f"echogrid drive: {run.excursion.trouble}", file=sys.stderr)
    return 1 if run.excursion.trouble else 0


def _stop_on_signals(excursion: "Excursion") -> None:
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: excursion.stop())


def _show(stage: "Stage", pose: "Pose") -> None:
    print(
        f"{stage.value:22} x {pose.x:+.3f} m  y {pose.y:+.3f} m  yaw {degrees(pose.yaw):+.1f} deg", flush=True
    )
