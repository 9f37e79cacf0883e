"""echogrid fault: let a device or bus of the emulated robot fail."""

import argparse
import sys
from typing import TYPE_CHECKING, Any

from echogrid.runtime.commands.arguments import add_directory, duration

if TYPE_CHECKING:
    from echogrid.runtime.commands.arguments import Commands


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser(
        "fault",
        help="let a device of the emulated robot fail",
        description="echogrid fault list | DEVICE VERB [--for 3s] | DEVICE clear",
    )
    parser.add_argument("device", metavar="DEVICE", help="a device or bus, or `list`")
    parser.add_argument(
        "verb", metavar="VERB", nargs="?", help="off, garbage, delayed, unplug ... or `clear`"
    )
    parser.add_argument(
        "--for", dest="for_s", type=duration, metavar="TIME", help="how long (default: for good)"
    )
    add_directory(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Tell the emulated robot; the exit code."""
    from echogrid.emulation.control import request

    if arguments.device != "list" and arguments.verb is None:
        print(f"echogrid fault: say what {arguments.device} is to suffer; `list` shows it", file=sys.stderr)
        return 2
    done = request(arguments.dir / "control.sock", _message(arguments))
    if arguments.device == "list":
        _show(done)
    return 0


def _message(arguments: argparse.Namespace) -> dict[str, Any]:
    if arguments.device == "list":
        return {"list": True}
    if arguments.verb == "clear":
        return {"clear": arguments.device}
    return {"fault": arguments.device, "verb": arguments.verb, "for_s": arguments.for_s}


def _show(answer: Any) -> None:
    active: dict[str, list[str]] = {}
    for fault in answer["faults"]:
        active.setdefault(fault["name"], []).append(_lasting(fault["verb"], fault["for_s"]))
    width = max(map(len, answer["verbs"]), default=0)
    for name, verbs in answer["verbs"].items():
        now = f"  now: {', '.join(active[name])}" if name in active else ""
        print(f"{name:{width}}  {', '.join(verbs)}{now}")


def _lasting(verb: str, left_s: float | None) -> str:
    return verb if left_s is None else f"{verb} (for {left_s:.1f} s more)"
