"""The guest's own files: its kernel and the packages that the host lacks; built once, then cached."""

import fcntl
import hashlib
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from hil_tests.guest import packages
from hil_tests.guest.errors import GuestError
from hil_tests.guest.vmlinux import extract

KERNEL = "linux-image-amd64"
TOOLS = ("can-utils", "i2c-tools", "iproute2", "systemd", "udev")
ALWAYS = ("busybox-static", "kmod")
"""Used on the host as well, from the tree."""


@dataclass(frozen=True, slots=True)
class Tree:
    """Laid over the host's root in the guest."""

    root: Path

    @property
    def kernel(self) -> Path:
        """What QEMU boots."""
        plain = self.root / "boot" / "vmlinux"
        return plain if plain.exists() else next((self.root / "boot").glob("vmlinuz-*"))

    @property
    def modules(self) -> Path:
        """The folder of the kernel's modules."""
        return next((self.root / "usr/lib/modules").iterdir())

    @property
    def busybox(self) -> Path:
        """A static busybox."""
        return self.root / "usr/bin/busybox"


def kernel_tree(cache: Path) -> Tree:
    """The tree from the cache folder, built there if it is not yet. Raises GuestError."""
    recipe = "\n".join((KERNEL, *TOOLS, *ALWAYS, Path(__file__).read_text(encoding="utf-8")))
    root = cache / f"tree-{hashlib.sha256(recipe.encode()).hexdigest()[:16]}"
    try:
        with _locked(cache):
            if not root.exists():
                _build(root)
    except OSError as error:
        raise GuestError(f"{cache}: cannot be used: {error}") from error
    return Tree(root)


@contextmanager
def _locked(cache: Path) -> Iterator[None]:
    cache.mkdir(parents=True, exist_ok=True)
    with (cache / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _build(root: Path) -> None:
    """Build beside, then rename: what is there is whole. Trees of other recipes go."""
    for stale in root.parent.glob("tree-*"):
        shutil.rmtree(stale)
    fresh = Tree(root.with_name(f"{root.name}.new"))
    packages.update()
    kernel = packages.kernel_package(KERNEL)
    packages.unpack({kernel, *packages.missing(TOOLS), *ALWAYS}, fresh.root)
    if not fresh.busybox.exists():
        raise GuestError("busybox-static holds no usr/bin/busybox")
    _index_modules(fresh)
    plain = extract(fresh.kernel.read_bytes())
    if plain is not None:
        (fresh.root / "boot" / "vmlinux").write_bytes(plain)
    fresh.root.rename(root)


def _index_modules(tree: Tree) -> None:
    """Write modules.dep: kernel packages leave that to their installation."""
    command = ["depmod", "-b", str(tree.root), tree.modules.name]
    done = subprocess.run(
        command, executable=tree.root / "usr/bin/kmod", capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise GuestError(f"depmod failed: {done.stderr.strip()}")
