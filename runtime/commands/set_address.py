"""echogrid set-address: give a ranger another address, for good."""

import argparse
import sys
from typing import TYPE_CHECKING

from echogrid.runtime.commands.arguments import add_settings

if TYPE_CHECKING:
    from echogrid.runtime.commands.arguments import Commands


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser(
        "set-address",
        help="give a ranger another address",
        description=f"{__doc__} Only one device may be at the present address: a second one would get "
        "the new address, too. It asks before it does so, and looks afterwards whether it came about; "
        "with devices which move at their next power-up, that is left to you.",
    )
    parser.add_argument("driver", metavar="DRIVER", help="such as srf08")
    parser.add_argument("port", metavar="PORT", help="such as /dev/i2c-1 or /dev/ttyUSB0")
    parser.add_argument("old", type=_address, metavar="OLD", help="the present address, such as 0x70 (7 bit)")
    parser.add_argument("new", type=_address, metavar="NEW", help="the new one, such as 0x71 (7 bit)")
    add_settings(parser, "a key of the driver, such as baud=9600")
    parser.add_argument("--yes", action="store_true", help="don't ask")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Change it; the exit code: 1 if that failed, or was not wanted."""
    from echogrid.drivers.clock import MonotonicClock
    from echogrid.runtime.readdressing import Readdress

    addresses = arguments.old, arguments.new
    readdress = Readdress(
        arguments.driver, arguments.port, addresses, dict(arguments.settings), MonotonicClock()
    )
    print(readdress.found())
    if not (arguments.yes or _agreed(arguments)):
        print("nothing was changed", file=sys.stderr)
        return 1
    readdress.carry_out()
    if readdress.after_power_cycle:
        print(
            f"done: it took the message, and moves to {arguments.new:#04x} at its next power-up. Then look:"
        )
        print(f"echogrid read {arguments.driver} --port {arguments.port} --set address={arguments.new:#04x}")
        return 0
    print(f"done: {readdress.proof()}")
    return 0


def _agreed(arguments: argparse.Namespace) -> bool:
    """Whether the person at the terminal agrees; without a terminal nobody does."""
    question = (
        f"give it the address {arguments.new:#04x}, for good? Is it the only one at {arguments.old:#04x}?"
    )
    if not sys.stdin.isatty():
        print(f"{question} (no terminal to ask at: --yes says so)", file=sys.stderr)
        return False
    print(f"{question} [y/N] ", end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _address(text: str) -> int:
    try:
        return int(text, 0)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no address (try 0x71)") from None
