"""Debian packages: QEMU installed on the host, the guest's own only downloaded and unpacked."""

import contextlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from hil_tests.guest.errors import GuestError

QEMU = "qemu-system-x86"
QEMU_COMMAND = "qemu-system-x86_64"
QUIET = {**os.environ, "DEBIAN_FRONTEND": "noninteractive", "LC_ALL": "C"}
UNWANTED = ("./usr/share/doc", "./usr/share/man", "./usr/share/locale")


def require_qemu() -> None:
    """Install QEMU unless it is there. Raises GuestError."""
    if shutil.which(QEMU_COMMAND):
        return
    update()
    command = ["apt-get", "install", "-y", "-qq", "--no-install-recommends", QEMU]
    _check(_as_root(command), f"cannot install {QEMU}")


def update() -> None:
    """Learn the newest packages; should that fail, the known ones must do."""
    with contextlib.suppress(OSError):
        subprocess.run(_as_root(["apt-get", "update", "-qq"]), env=QUIET, capture_output=True, check=False)


def kernel_package(meta: str) -> str:
    """The package of the kernel that a meta-package stands for."""
    said = _check(["apt-cache", "depends", meta], f"cannot find {meta}")
    for line in said.splitlines():
        kind, _, name = line.strip().partition(": ")
        if kind == "Depends" and name.startswith("linux-image-"):
            return name
    raise GuestError(f"cannot find the kernel of {meta}: is this Debian on amd64?")


def missing(names: Iterable[str]) -> set[str]:
    """These packages and what they depend on, as far as this host lacks them."""
    wanted = sorted(names)
    command = ["apt-get", "install", "--simulate", "--no-install-recommends", *wanted]
    said = _check(command, f"cannot find {', '.join(wanted)}")
    return {line.split()[1] for line in said.splitlines() if line.startswith("Inst ")}


def unpack(names: Iterable[str], root: Path) -> None:
    """Download packages and unpack them below `root`, laid out with /lib, /bin and /sbin in /usr."""
    for folder in ("lib", "lib64", "bin", "sbin"):
        (root / "usr" / folder).mkdir(parents=True)
        (root / folder).symlink_to(f"usr/{folder}")
    with tempfile.TemporaryDirectory(prefix="echogrid-hil-") as folder:
        _check(["apt-get", "download", *sorted(names)], "cannot download the guest's packages", folder)
        for package in sorted(Path(folder).glob("*.deb")):
            _unpack_one(package, root)


def _unpack_one(package: Path, root: Path) -> None:
    exclude = [f"--exclude={path}" for path in UNWANTED]
    with subprocess.Popen(["dpkg-deb", "--fsys-tarfile", package], stdout=subprocess.PIPE) as archive:
        command = ["tar", "-x", "--keep-directory-symlink", *exclude, "-C", str(root)]
        tar = subprocess.run(command, stdin=archive.stdout, capture_output=True, text=True, check=False)
    if archive.returncode or tar.returncode:
        raise GuestError(f"cannot unpack {package.name}: {_last_line(tar.stderr)}")


def _as_root(command: list[str]) -> list[str]:
    return command if os.geteuid() == 0 else ["sudo", "DEBIAN_FRONTEND=noninteractive", *command]


def _check(command: Sequence[str], failure: str, folder: str | None = None) -> str:
    """What the command prints. Raises GuestError with its last word if it fails."""
    try:
        done = subprocess.run(command, cwd=folder, env=QUIET, capture_output=True, text=True, check=False)
    except OSError as error:
        raise GuestError(f"{failure}: {error}") from error
    if done.returncode:
        raise GuestError(f"{failure}: {_last_line(done.stderr)}")
    return done.stdout


def _last_line(text: str) -> str:
    return text.strip().rpartition("\n")[2] or "no word of why"
