"""The emulated robot as a child process, for a run that was given no robot."""

import contextlib
import ctypes
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from struct import Struct

from echogrid.drivers.errors import EchogridError

_START_S = 20.0
_STOP_S = 5.0
_POLL_S = 0.05
_PR_SET_PDEATHSIG = 1
_CREDENTIALS = Struct("iII")
"""ucred: process, user, group."""


class EmulatorError(EchogridError):
    """The emulated robot did not start."""


@contextlib.contextmanager
def emulator(directory: Path, seed: int, *, driven: bool = False) -> Iterator[None]:
    """The emulated robot, served in that folder while the context lasts. Raises EmulatorError.

    `driven`: it goes where its motors are commanded to, instead of touring.
    """
    command = [sys.executable, "-m", "echogrid", "emulate", "--dir", str(directory), "--seed", str(seed)]
    command += ["--driven"] if driven else []
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=partial(_die_with_parent, os.getpid(), ctypes.CDLL(None)),
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
        if _server(control) == process.pid:
            return
        time.sleep(_POLL_S)
    raise EmulatorError(f"the emulated robot did not answer at {control} within {_START_S:.0f} s")


def _server(control: Path) -> int | None:
    """The process that listens there, if there is one: another emulator may, where ours can't."""
    with socket.socket(socket.AF_UNIX) as client:
        try:
            client.connect(str(control))
        except OSError:
            return None
        credentials = client.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    process: int = _CREDENTIALS.unpack(credentials)[0]
    return process


def _die_with_parent(parent: int, libc: ctypes.CDLL) -> None:
    """In the child: have the kernel end it when the run is gone, however that came about."""
    libc.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGTERM)
