"""python -m hil_tests.guest [--timeout S] [--out DIR] -- CMD ...: run a command inside, return its exit code.

The command runs as root in the folder that it is started from. The guest's root is the host's own, read-only
under an overlay; of what it writes, only /run/bench-out is kept, in the folder given by --out.
"""

import argparse
import os
import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hil_tests.guest.errors import GuestError
from hil_tests.guest.initramfs import initramfs
from hil_tests.guest.machine import NO_CODE, Machine, run
from hil_tests.guest.packages import require_qemu
from hil_tests.guest.tree import kernel_tree

INTERRUPTED = 130


def main() -> int:
    """Run the command; its exit code, or 124 after a timeout, 125 without a guest or a code."""
    arguments = _arguments()
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        require_qemu()
        tree = kernel_tree(_cache())
        with _folder(arguments.out) as out:
            image = out / "initramfs.img"
            image.write_bytes(initramfs(tree))
            return run(Machine(tree.kernel, image, tree.root, out), arguments.command, arguments.timeout)
    except GuestError as error:
        sys.stderr.write(f"no guest: {error}\n")
        return NO_CODE
    except KeyboardInterrupt:
        return INTERRUPTED


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m hil_tests.guest", description=__doc__)
    parser.add_argument(
        "--timeout",
        type=float,
        default=600.0,
        metavar="S",
        help="seconds for boot and command (default: 600)",
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="keep the console, the output and /run/bench-out there"
    )
    parser.add_argument("command", nargs="+", metavar="CMD", help="what to run, after --")
    return parser.parse_args()


def _cache() -> Path:
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "echogrid-hil"


@contextmanager
def _folder(kept: Path | None) -> Iterator[Path]:
    if kept is None:
        with tempfile.TemporaryDirectory(prefix="echogrid-hil-") as name:
            yield Path(name)
    else:
        kept.mkdir(parents=True, exist_ok=True)
        yield kept.resolve()


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


if __name__ == "__main__":
    sys.exit(main())
