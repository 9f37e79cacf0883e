"""echogrid on the command line: results on stdout, messages on stderr; exit 0 done, 1 failed, 2 misused."""

import argparse
import os
import sys
from collections.abc import Sequence

from echogrid import __version__
from echogrid.drivers.errors import EchogridError
from echogrid.runtime.commands import (
    calibrate,
    compare,
    drive,
    emulate,
    evaluate,
    explain,
    fault,
    make_map,
    read,
    run,
    scan,
    schedule,
    set_address,
    trial,
)
from echogrid.runtime.errors import UsageError

_COMMANDS = (
    run,
    make_map,
    schedule,
    scan,
    read,
    set_address,
    calibrate,
    compare,
    drive,
    emulate,
    fault,
    evaluate,
    explain,
    trial,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the arguments say; the exit code."""
    _stand_in_for_closed_streams()
    try:
        code = _done(arguments)
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for stream in (sys.stdout, sys.stderr):
            os.dup2(nowhere, stream.fileno())
        return 1


def _stand_in_for_closed_streams() -> None:
    """What is said to a stream that is closed from the start goes nowhere, and no port gets its number."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_RDWR), mode))


def _done(arguments: Sequence[str] | None) -> int:
    try:
        chosen = _parser().parse_args(arguments)
        code: int = chosen.execute(chosen)
        return code
    except SystemExit as end:  # How argparse ends after --help, or after a mistake.
        return end.code if isinstance(end.code, int) else 2
    except UsageError as error:
        print(error, file=sys.stderr)
        return 2
    except BrokenPipeError:
        raise
    except (EchogridError, OSError) as error:
        print(_told(error), file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="echogrid", description=__doc__.split(":")[0])
    parser.add_argument("--version", action="version", version=f"echogrid {__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in _COMMANDS:
        command.add(commands)
    return parser


def _told(error: Exception) -> str:
    if isinstance(error, FileExistsError | NotADirectoryError):
        return f"{error.filename}: is no folder"
    if isinstance(error, OSError) and not isinstance(error, EchogridError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    return str(error)
