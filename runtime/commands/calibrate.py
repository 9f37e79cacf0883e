"""echogrid calibrate odometry: the wheels' true measures from recorded runs."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import length
from echogrid.runtime.errors import UsageError

if TYPE_CHECKING:
    from echogrid.runtime.calibration import Calibration
    from echogrid.runtime.commands.arguments import Commands


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser("calibrate", help="measure the robot by runs that it drove")
    parts = parser.add_subparsers(metavar="WHAT", required=True)
    odometry = parts.add_parser("odometry", help="measures of the wheels", description=__doc__)
    odometry.add_argument(
        "logs", type=Path, nargs="+", metavar="LOG", help="the folder of a recorded run, one run in each"
    )
    kind = odometry.add_mutually_exclusive_group(required=True)
    kind.add_argument(
        "--square",
        action="store_true",
        help="each is once round a square, some clockwise, some counter-clockwise: finds unequal wheels and "
        "the track (UMBmark)",
    )
    kind.add_argument(
        "--straight",
        type=length,
        metavar="METRES",
        help="each is straight on, so far: finds the wheels' radius, and the zero of a steering",
    )
    odometry.add_argument(
        "--end",
        nargs=3,
        action="append",
        default=[],
        metavar=("LOG", "X", "Y"),
        help="where that square truly ended: m from its start, ahead and to the left (default: on its start)",
    )
    odometry.add_argument("--write", type=Path, metavar="robot.toml", help="put what was found there")
    odometry.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Tell what is found, and write it if that is wanted; the exit code."""
    from echogrid.runtime import calibration

    logs = calibration.read(arguments.logs, dict(map(_end, arguments.end)))
    for line in logs.faults.lines():
        print(line, file=sys.stderr)
    found = (
        calibration.by_squares(logs)
        if arguments.square
        else calibration.by_straights(logs, arguments.straight)
    )
    print("\n".join(found.lines()))
    print(_written(found, arguments.write))
    return 0


def _written(found: "Calibration", path: Path | None) -> str:
    from echogrid.runtime import calibration

    if path is None:
        return "nothing was written (--write robot.toml does it)"
    changed = calibration.write(path, found)
    return f"{path}: {', '.join(changed) or 'nothing'} changed"


def _end(words: list[str]) -> tuple[Path, tuple[float, float]]:
    folder, x, y = words
    try:
        return Path(folder), (float(x), float(y))
    except ValueError:
        raise UsageError([f"--end {folder} {x} {y}: X and Y are metres, such as 0.12 -0.05"]) from None
