"""echogrid evaluate: how good maps, firing and odometry are, emulated and on a real recording."""

import argparse
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_seed, count, length
from echogrid.runtime.errors import UsageError

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
    parser.add_argument(
        "--maps", action="store_true", help="judge every theory in the frozen worlds instead (minutes)"
    )
    parser.add_argument(
        "--seeds", type=count, default=5, metavar="N", help="with --maps: laps through each (default: 5)"
    )
    parser.add_argument(
        "--worlds", type=worlds, metavar="A,B", help="with --maps: only in these worlds (default: all)"
    )
    parser.add_argument(
        "--processes", type=count, default=2, metavar="N", help="with --maps: so many at a time (default: 2)"
    )
    add_seed(parser)
    parser.set_defaults(execute=execute)


def worlds(text: str) -> list[str]:
    """Names of frozen worlds, from a list with commas."""
    from echogrid.emulation.worlds import WORLDS

    names = [name.strip() for name in text.split(",")]
    if strangers := [name for name in names if name not in WORLDS]:
        raise argparse.ArgumentTypeError(f"no world is called {strangers[0]!r} (try {','.join(WORLDS)})")
    return names


def execute(arguments: argparse.Namespace) -> int:
    """Print the tables; the exit code. Raises UsageError for worlds of which nothing would come."""
    if arguments.worlds and not arguments.maps:
        raise UsageError(["--worlds is for --maps: without that nothing is judged in the frozen worlds"])
    for line in _theories(arguments) if arguments.maps else _everything(arguments):
        print(line, flush=True)
    return 0


def _theories(arguments: argparse.Namespace) -> Iterator[str]:
    from echogrid.emulation.worlds import WORLDS
    from echogrid.runtime import map_table
    from echogrid.runtime.contenders import contenders

    seeds = range(arguments.seed, arguments.seed + arguments.seeds)
    return map_table.tables(arguments.worlds or list(WORLDS), seeds, contenders(), arguments.processes)


def _everything(arguments: argparse.Namespace) -> Iterator[str]:
    from echogrid.runtime import acoustics_check, crosstalk_check, evaluation, odometry_check

    maps = evaluation.tables(arguments.seed, arguments.metres, arguments.robond)
    firing = crosstalk_check.table(arguments.seed, arguments.metres)
    wheels = odometry_check.table(evaluation.default_config(), arguments.seed)
    return chain(maps, [""], firing, [""], wheels, [""], acoustics_check.table(seed=arguments.seed))
