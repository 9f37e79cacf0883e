"""What the kernel starts: mounts the host's root under an overlay, adds the bench's units, starts systemd."""

from collections.abc import Iterator
from pathlib import Path

from hil_tests.guest import cpio
from hil_tests.guest.modules import loading_order
from hil_tests.guest.tree import Tree

MODULES = ("virtio_pci", "9pnet_virtio", "9p", "overlay")
FOLDERS = ("bin", "proc", "sys", "dev", "host", "tree", "written", "root", "modules", "units")
APPLETS = ("sh", "cat", "cp", "insmod", "mkdir", "mount", "poweroff", "rm", "switch_root")
HERE = Path(__file__).parent


def initramfs(tree: Tree) -> bytes:
    """The archive, for that tree's kernel."""
    modules = loading_order(tree.modules, MODULES)
    order = "".join(f"{name}\n" for name, _ in modules)
    return cpio.archive(
        [
            *map(cpio.folder, FOLDERS),
            cpio.file("init", (HERE / "init.sh").read_bytes()),
            cpio.file("bin/busybox", tree.busybox.read_bytes()),
            *(cpio.link(f"bin/{applet}", "busybox") for applet in APPLETS),
            cpio.file("modules/order", order.encode()),
            *(cpio.file(f"modules/{name}", data) for name, data in modules),
            *_units(),
        ]
    )


def _units() -> Iterator[cpio.Entry]:
    for unit in ("bench.target", "bench.service"):
        yield cpio.file(f"units/{unit}", (HERE / "units" / unit).read_bytes())
    yield cpio.link("units/default.target", "bench.target")
    for masked in (HERE / "units" / "masked").read_text().split():
        yield cpio.link(f"units/{masked}", "/dev/null")
