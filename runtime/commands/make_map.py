"""echogrid map: a map from a recording."""

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_log, add_theory, length, recorded

if TYPE_CHECKING:
    from echogrid.runtime.commands.arguments import Commands
    from echogrid.runtime.recording import Recording


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser("map", help="make a map from a recording", description=__doc__)
    add_log(parser)
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="where the map files go")
    add_theory(parser)
    parser.add_argument(
        "--no-echo", choices=("ignore", "weak", "clear"), help="what silence means (default: as configured)"
    )
    parser.add_argument("--resolution", type=length, metavar="METRES", help="the side of a cell")
    parser.add_argument("--strict", action="store_true", help="exit with 1 if any row was skipped")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Make the map; the exit code."""
    from echogrid.runtime import map_files, offline

    recording = _recording(arguments)
    made = offline.build(recording)
    map_files.write(arguments.out, made.image, recording.poses)
    report = json.dumps(made.report(recording.faults), indent=2) + "\n"
    map_files.replace(arguments.out / "report.json", report.encode())
    for line in recording.faults.lines():
        print(line, file=sys.stderr)
    heard = {reading.sensor for _, reading in recording.ranges}
    if unheard := [sensor.name for sensor in recording.config.sensor if sensor.name not in heard]:
        print(f"no rows of these sensors: {', '.join(unheard)}", file=sys.stderr)
    print(f"{made.ledger.fused} of {made.ledger.produced} readings fused; the map is in {arguments.out}")
    return 1 if arguments.strict and recording.faults.counts else 0


def _recording(arguments: argparse.Namespace) -> "Recording":
    from echogrid.mapping.sonar_model import NoEcho
    from echogrid.runtime.errors import UsageError

    told = recorded(arguments)
    area = told.config.map
    try:
        chosen = replace(
            area,
            theory=arguments.theory or area.theory,
            no_echo=NoEcho(arguments.no_echo) if arguments.no_echo else area.no_echo,
            resolution_m=arguments.resolution or area.resolution_m,
        )
    except ValueError as error:
        raise UsageError([f"echogrid map: {error}"]) from error
    if arguments.no_echo and chosen.theory in ("counting", "calibrated"):
        heeding = "bayes, dempster-shafer and himm"
        raise UsageError([f"echogrid map: --no-echo is for --theory {heeding}, not {chosen.theory}"])
    return replace(told, config=replace(told.config, map=chosen))
