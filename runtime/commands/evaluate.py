"""echogrid evaluate: how good maps, firing and odometry are, emulated and on a real recording."""

import argparse
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_seed, length

if TYPE_CHECKING:
    from echogrid.runtime.commands.arguments import Commands


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser(
        "evaluate", help="measure maps, firing, odometry and the emulated acoustics", description=__doc__
    )
    parser.add_argument(
        "--metres", type=length, default=60.0, help="how far to drive through the office (default: 60)"
    )
    parser.add_argument("--robond", type=Path, metavar="DIR", help="also judge the RoboND recording in DIR")
    add_seed(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Print the tables; the exit code."""
    from echogrid.runtime import acoustics_check, crosstalk_check, evaluation, odometry_check

    maps = evaluation.tables(arguments.seed, arguments.metres, arguments.robond)
    firing = crosstalk_check.table(arguments.seed, arguments.metres)
    wheels = odometry_check.table(evaluation.default_config(), arguments.seed)
    for line in chain(maps, [""], firing, [""], wheels, [""], acoustics_check.table(seed=arguments.seed)):
        print(line, flush=True)
    return 0
