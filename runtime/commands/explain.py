"""echogrid explain: which pings made a cell of the map what it is."""

import argparse
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_log, count, finite, recorded

if TYPE_CHECKING:
    from echogrid.runtime.commands.arguments import Commands


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser("explain", help="tell why a cell is what it is", description=__doc__)
    add_log(parser)
    parser.add_argument("x", type=finite, metavar="X", help="m, in the frame of the map")
    parser.add_argument("y", type=finite, metavar="Y")
    parser.add_argument("--most", type=count, default=20, metavar="N", help="how many pings (default: 20)")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Print it; the exit code."""
    from echogrid.runtime import assembly
    from echogrid.runtime.explanation import explain, told

    recording = recorded(arguments)
    witness = explain(recording, arguments.x, arguments.y, assembly.theory(recording.config))
    for line in told(witness, arguments.most):
        print(line)
    return 0
