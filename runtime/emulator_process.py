"""The emulated robot as a child process, for a run that was given no robot."""

import contextlib
import ctypes
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from echogrid.drivers.errors import EchogridError
from echogrid.emulation.control import request
from echogrid.emulation.errors import ControlError

_START_S = 20.0
_STOP_S = 5.0
_POLL_S = 0.05
_PR_SET_PDEATHSIG = 1


class EmulatorError(EchogridError):
    """The emulated robot did not start."""


@contextlib.contextmanager
def emulator(directory: Path, seed: int) -> Iterator[None]:
    """The emulated robot, served in that folder while the context lasts. Raises EmulatorError."""
    command = [sys.executable, "-m", "echogrid", "emulate", "--dir", str(directory), "--seed", str(seed)]
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=_die_with_parent,
    )
    try:
        _await(process, directory / "control.sock")
        yield
    finally:
        process.terminate()
        try:
            process.communicate(timeout=_STOP_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()


def _await(process: "subprocess.Popen[str]", control: Path) -> None:
    """Wait until it answers."""
    deadline = time.monotonic() + _START_S
    while time.monotonic() < deadline:
        if process.poll() is not None:
            said = process.communicate()[1].strip()
            raise EmulatorError(f"the emulated robot did not start: {said or 'no word of why'}")
        with contextlib.suppress(ControlError):
            request(control, {"list": True})
            return
        time.sleep(_POLL_S)
    raise EmulatorError(f"the emulated robot did not answer at {control} within {_START_S:.0f} s")


def _die_with_parent() -> None:
    """In the child: have the kernel end it when the run is gone, however that came about."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
