"""echogrid compare: every theory on one log, side by side."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_log, recorded

if TYPE_CHECKING:
    from echogrid.runtime.commands.arguments import Commands
    from echogrid.runtime.comparison import Comparison, Truth
    from echogrid.runtime.comparison_report import Heading
    from echogrid.runtime.comparison_tables import Table
    from echogrid.runtime.recording import Recording

EMULATED = "emulated"


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser(
        "compare", help="set the maps of all theories side by side", description=__doc__
    )
    add_log(parser)
    parser.add_argument(
        "--truth",
        metavar="MAP",
        help="map.yaml or map.npz, in the log's frame; emulated: the built-in office, for a log made in it",
    )
    parser.add_argument(
        "--out",
        type=out,
        metavar="FILE",
        help="FILE.html: the report, in one file; FILE.png: its pictures alone",
    )
    parser.add_argument(
        "--theories", type=theories, metavar="A,B", help="only these of them (default: all nine)"
    )
    parser.add_argument(
        "--no-timing", action="store_true", help="leave out the microseconds, which no two runs have alike"
    )
    parser.set_defaults(execute=execute)


def theories(text: str) -> tuple[str, ...]:
    """Names of theories, from a list with commas."""
    from echogrid.runtime.compared_theories import WHAT_IT_IS

    names = tuple(name.strip() for name in text.split(","))
    if strangers := [name for name in names if name not in WHAT_IT_IS]:
        told = f"no theory is called {strangers[0]!r} (try {','.join(WHAT_IT_IS)})"
        raise argparse.ArgumentTypeError(told)
    return names


def out(text: str) -> Path:
    """Where the report or its pictures go."""
    if not text.endswith((".html", ".png")):
        raise argparse.ArgumentTypeError(f"{text!r} is neither FILE.html nor FILE.png")
    return Path(text)


def execute(arguments: argparse.Namespace) -> int:
    """Compare, print the tables and write the report; the exit code."""
    from echogrid.runtime import comparison, map_files
    from echogrid.runtime.compared_theories import WHAT_IT_IS
    from echogrid.runtime.comparison_tables import as_text, tables

    recording, truth = _material(arguments)
    names = arguments.theories or tuple(WHAT_IT_IS)
    found = comparison.compare(recording, truth, names, lambda name: print(name, file=sys.stderr, flush=True))
    for line in recording.faults.lines():
        print(line, file=sys.stderr)
    told = tables(found, timing=not arguments.no_timing)
    if arguments.out:
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        map_files.replace(arguments.out, _file(arguments, found, told))
    for table in told:
        print(*as_text(table), "", sep="\n")
    return 0


def _file(arguments: argparse.Namespace, found: "Comparison", told: "tuple[Table, ...]") -> bytes:
    from echogrid.runtime import comparison_report, png
    from echogrid.runtime.comparison_pictures import maps
    from echogrid.runtime.comparison_scenes import scenes
    from echogrid.runtime.picture_sheet import sheets

    galleries = [maps(found), *scenes(found.steered)]
    if arguments.out.suffix == ".png":
        return png.encode(sheets(galleries))
    return comparison_report.report(_heading(arguments, found), galleries, told).encode()


def _material(arguments: argparse.Namespace) -> tuple["Recording", "Truth | None"]:
    from echogrid.runtime import office_truth, truth_map

    log = recorded(arguments)
    if arguments.truth == EMULATED:
        return office_truth.in_office(log)
    return log, truth_map.read(Path(arguments.truth)) if arguments.truth else None


def _heading(arguments: argparse.Namespace, found: "Comparison") -> "Heading":
    from echogrid.runtime.comparison_report import Heading

    size = found.geometry.resolution
    facts = (
        f"{found.pings} pings, {found.echoes} of them with an echo; cells of {size:g} m.",
        "Every theory was given the same pings, each at the pose that the log has for it.",
        f"Truth: {_truth_told(arguments.truth)}.",
    )
    return Heading(f"Theories compared: {arguments.log.resolve().name}", facts)


def _truth_told(truth: str | None) -> str:
    if truth is None:
        return "none; so no map is judged, but each is compared with each"
    return "the built-in office" if truth == EMULATED else Path(truth).name
