"""echogrid explain: which pings made a cell of the map what it is."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import count, finite

if TYPE_CHECKING:
    from echogrid.runtime.commands.arguments import Commands


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser("explain", help="tell why a cell is what it is", description=__doc__)
    parser.add_argument("log", type=Path, metavar="LOG", help="the folder of a recording")
    parser.add_argument("x", type=finite, metavar="X", help="m, in the frame of the map")
    parser.add_argument("y", type=finite, metavar="Y")
    parser.add_argument("--most", type=count, default=20, metavar="N", help="how many pings (default: 20)")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Print it; the exit code."""
    from echogrid.runtime import assembly
    from echogrid.runtime.explanation import explain, told
    from echogrid.runtime.recording import read_simple

    recording = read_simple(arguments.log)
    witness = explain(recording, arguments.x, arguments.y, assembly.theory(recording.config))
    for line in told(witness, arguments.most):
        print(line)
    return 0
