"""echogrid calibrate: the wheels' true measures, and what the rangers are like, from recorded runs."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_log, add_seed, length, recorded
from echogrid.runtime.errors import UsageError

if TYPE_CHECKING:
    from echogrid.runtime.calibration import Calibration
    from echogrid.runtime.commands.arguments import Commands
    from echogrid.runtime.recording import Recording
    from echogrid.runtime.reference_map import LoggedPing, Reference


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser("calibrate", help="measure the robot by runs that it drove")
    parts = parser.add_subparsers(metavar="WHAT", required=True)
    _add_odometry(parts)
    _add_sensor(parts)


def _add_odometry(parts: "Commands") -> None:
    told = "The wheels' true measures from recorded runs."
    odometry = parts.add_parser("odometry", help="measures of the wheels", description=told)
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
    odometry.set_defaults(execute=execute_odometry)


def _add_sensor(parts: "Commands") -> None:
    told = "Beam, noise, mounting angle and sonar model of every ranger, from ten minutes of driving."
    sensor = parts.add_parser("sensor", help="what the rangers are like", description=told)
    add_log(sensor)
    sensor.add_argument(
        "--truth",
        metavar="MAP",
        help="map.yaml or map.npz, in the log's frame; emulated: the built-in office, for a log made in it "
        "(default: the log's own map)",
    )
    sensor.add_argument("--write", type=Path, metavar="robot.toml", help="put what was found there")
    add_seed(sensor)
    sensor.set_defaults(execute=execute_sensor)


def execute_sensor(arguments: argparse.Namespace) -> int:
    """Print the model card, and write what is better than what is configured; the exit code."""
    from echogrid.runtime import sensor_calibration, sensor_card, sensor_writing

    recording, pings, reference = _judged_by(arguments)
    for line in recording.faults.lines():
        print(line, file=sys.stderr)
    results = sensor_calibration.results(recording, pings, reference, arguments.seed)
    print("\n".join(sensor_card.lines(recording.config, results, reference.own)))
    if arguments.write is None:
        print("nothing was written (--write robot.toml does it)")
        return 0
    changed = sensor_writing.write(arguments.write, sensor_writing.mended(recording.config, results))
    for line in changed or ["nothing changed"]:
        print(f"{arguments.write}: {line}")
    return 0


def _judged_by(arguments: argparse.Namespace) -> "tuple[Recording, list[LoggedPing], Reference]":
    """The log, its pings, and the map by which they are judged."""
    from echogrid.runtime import reference_map

    log = recorded(arguments)
    if arguments.truth is None:
        pings = reference_map.placed(log)
        return log, pings, reference_map.of_itself(log, pings)
    if arguments.truth == "emulated":
        log, reference = reference_map.in_emulated(log)
    else:
        log, reference = reference_map.in_known(log, Path(arguments.truth))
    return log, reference_map.placed(log), reference


def execute_odometry(arguments: argparse.Namespace) -> int:
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
