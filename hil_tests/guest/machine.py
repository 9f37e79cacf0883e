"""QEMU as the guest's hardware, emulated to the last instruction: it needs nothing of the host's kernel."""

import ctypes
import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hil_tests.guest.errors import GuestError
from hil_tests.guest.packages import QEMU_COMMAND

TIMEOUT, NO_CODE = 124, 125
MEMORY = "1024M"
POLL_S = 0.1
PR_SET_PDEATHSIG = 1
KERNEL_OPTIONS = "console=ttyS0 quiet panic=-1 nokaslr mitigations=off"


@dataclass(frozen=True, slots=True)
class Machine:
    """What it boots, and the folders that it sees."""

    kernel: Path
    initramfs: Path
    tree: Path
    out: Path
    """Shared with the guest, which may write there."""

    def command(self) -> list[str]:
        """How to start it."""
        return [
            *(QEMU_COMMAND, "-accel", "tcg,thread=multi", "-M", "q35", "-cpu", "Nehalem", "-smp", "1"),
            *("-m", MEMORY, "-nodefaults", "-display", "none", "-no-reboot", "-serial", "stdio"),
            *("-kernel", str(self.kernel), "-initrd", str(self.initramfs), "-append", KERNEL_OPTIONS),
            *_share("host", Path("/"), ",readonly=on"),
            *_share("tree", self.tree, ",readonly=on"),
            *_share("out", self.out, ""),
        ]


def run(machine: Machine, command: Sequence[str], timeout_s: float) -> int:
    """Run a command in the guest and show its output; its exit code, TIMEOUT or NO_CODE."""
    output, code = machine.out / "output", machine.out / "code"
    output.write_bytes(b"")
    code.unlink(missing_ok=True)
    script = f"cd {shlex.quote(str(Path.cwd()))} && exec {shlex.join(command)}\n"
    (machine.out / "command").write_text(script, encoding="utf-8")
    if not _follow(machine, output, timeout_s):
        sys.stderr.write(f"the guest was ended after {timeout_s:.0f} s\n")
        return TIMEOUT
    try:
        return int(code.read_text())
    except (OSError, ValueError):
        sys.stderr.write(f"no exit code from the guest; its console ended with:\n{_tail(machine)}\n")
        return NO_CODE


def _follow(machine: Machine, output: Path, timeout_s: float) -> bool:
    """Show what the guest prints until it ends; whether it did so by itself."""
    give_up = time.monotonic() + timeout_s
    with _console(machine).open("wb") as console, output.open("rb") as lines:
        process = _start(machine, console.fileno())
        try:
            while time.monotonic() < give_up:
                ended = process.poll() is not None
                sys.stdout.buffer.write(lines.read())
                sys.stdout.buffer.flush()
                if ended:
                    return True
                time.sleep(POLL_S)
            return False
        finally:
            _end(process)


def _start(machine: Machine, console: int) -> "subprocess.Popen[bytes]":
    try:
        return subprocess.Popen(
            machine.command(),
            stdin=subprocess.DEVNULL,
            stdout=console,
            stderr=console,
            start_new_session=True,
            preexec_fn=_die_with_parent,
        )
    except OSError as error:
        raise GuestError(f"cannot start {QEMU_COMMAND}: {error}") from error


def _end(process: "subprocess.Popen[bytes]") -> None:
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _die_with_parent() -> None:
    """In the child: have the kernel end it when the host's side is gone, however that came about."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def _share(name: str, folder: Path, more: str) -> tuple[str, ...]:
    """A folder of the host that the guest mounts by name."""
    backend = f"local,id={name},path={folder},security_model=none,multidevs=remap{more}"
    return "-fsdev", backend, "-device", f"virtio-9p-pci,fsdev={name},mount_tag={name}"


def _console(machine: Machine) -> Path:
    return machine.out / "console.log"


def _tail(machine: Machine) -> str:
    return "\n".join(_console(machine).read_text(errors="replace").splitlines()[-20:])
