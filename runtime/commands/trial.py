"""echogrid trial: emulated robots drive by their own senses through worlds; what happens is counted."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_seed, count

if TYPE_CHECKING:
    from collections.abc import Sequence

    from echogrid.runtime.commands.arguments import Commands
    from echogrid.runtime.trials.campaign import Plan
    from echogrid.runtime.trials.results import Line

RIGS = ("ring-16", "ring-12", "built-in")
_GOTO = "goto"
"""Who drives by bytes."""
FAULTS = ("none", "dead", "stuck", "silent", "dropouts")


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser(
        "trial", help="let pilots drive through emulated worlds, and count collisions", description=__doc__
    )
    parser.add_argument("--worlds", type=worlds, metavar="A,B", help="only in these (default: all)")
    parser.add_argument("--pilots", type=pilots, metavar="A,B", help="only these (default: all that look)")
    parser.add_argument(
        "--seeds", type=count, default=5, metavar="N", help="drives in each world (default: 5)"
    )
    parser.add_argument("--rig", choices=RIGS, help=f"the robot (default: {RIGS[0]})")
    parser.add_argument("--fault", choices=FAULTS, default=FAULTS[0], help="what is wrong with its rangers")
    parser.add_argument("--crosstalk", action="store_true", help="rangers hear each other (slower)")
    parser.add_argument(
        "--bytes",
        action="store_true",
        help="the built-in robot's own service drives (--goto), through real drivers and emulated devices",
    )
    parser.add_argument("--processes", type=count, default=2, metavar="N", help="at a time (default: 2)")
    parser.add_argument(
        "--results", type=Path, metavar="FILE", help="add results to FILE, and skip what it has already"
    )
    parser.add_argument("--failures", type=Path, metavar="DIR", help="keep logs of drives that fail in DIR")
    parser.add_argument("--replay", type=Path, metavar="FILE", help="drive such a log again, and compare")
    add_seed(parser)
    parser.set_defaults(execute=execute)


def worlds(text: str) -> list[str]:
    """Names of worlds, from a list with commas."""
    from echogrid.emulation.worlds.arenas import ARENAS

    return _named(text, list(ARENAS), "world")


def pilots(text: str) -> list[str]:
    """Names of pilots, from a list with commas."""
    from echogrid.runtime.trials.pilots import PILOTS

    return _named(text, list(PILOTS), "pilot")


def execute(arguments: argparse.Namespace) -> int:
    """Drive, or drive again; the exit code."""
    return _replay(arguments.replay) if arguments.replay else _campaign(arguments)


def _campaign(arguments: argparse.Namespace) -> int:
    from echogrid.runtime.trials import campaign, table
    from echogrid.runtime.trials.results import Results

    jobs, results = list(_plan(arguments).jobs()), Results(arguments.results)
    campaign.run(
        jobs, results, processes=arguments.processes, failures=arguments.failures, told=_tell_on_stderr
    )
    lines: Sequence[Line] = [results[job] for job in jobs]
    for row in table.tables(lines):
        print(row)
    print(table.speed(lines), file=sys.stderr)
    return 0


def _plan(arguments: argparse.Namespace) -> "Plan":
    """What is asked for. Raises UsageError for what does not go with bytes."""
    from echogrid.emulation.worlds.arenas import ARENAS
    from echogrid.runtime.errors import UsageError
    from echogrid.runtime.trials.campaign import Plan
    from echogrid.runtime.trials.pilots import PILOTS

    within = arguments.worlds or list(ARENAS)
    seeds = range(arguments.seed, arguments.seed + arguments.seeds)
    if not arguments.bytes:
        looking = arguments.pilots or [name for name in PILOTS if name != "blind"]
        rig = arguments.rig or RIGS[0]
        return Plan(within, looking, seeds, rig, arguments.fault, arguments.crosstalk)
    others = [
        option
        for option, given in (
            ("--pilots", arguments.pilots),
            (f"--rig {arguments.rig}", arguments.rig not in (None, RIGS[-1])),
            (f"--fault {arguments.fault}", arguments.fault != FAULTS[0]),
        )
        if given
    ]
    if others:
        raise UsageError([f"--bytes is the built-in robot, well, with its own pilot: leave out {others[0]}"])
    return Plan(within, [_GOTO], seeds, RIGS[-1], crosstalk=True, path="bytes")


def _tell_on_stderr(line: "Line") -> None:
    verdict = line.verdict
    print(f"{line.job.name}: {verdict.outcome} in {verdict.time_s:.1f} s", file=sys.stderr, flush=True)


def _replay(path: Path) -> int:
    from echogrid.runtime.trials.logs import replay

    again = replay(path)
    name = again.log.job.name
    if again.same:
        print(f"{name}: the same to the bit ({again.verdict.digest})")
        return 0
    where = "" if again.parted_s is None else f" from {again.parted_s:.2f} s on"
    print(f"{name}: another drive{where}: {again.log.verdict.digest} was {again.verdict.digest} now")
    return 1


def _named(text: str, known: list[str], kind: str) -> list[str]:
    names = [name.strip() for name in text.split(",")]
    if strangers := [name for name in names if name not in known]:
        raise argparse.ArgumentTypeError(f"no {kind} is called {strangers[0]!r} (try {','.join(known)})")
    return names
