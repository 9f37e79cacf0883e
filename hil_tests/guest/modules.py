"""Kernel modules with all that they need, in the order of loading."""

import lzma
from collections.abc import Sequence
from pathlib import Path

from hil_tests.guest.errors import GuestError


def loading_order(folder: Path, wanted: Sequence[str]) -> list[tuple[str, bytes]]:
    """File name and uncompressed contents of each module; those built in are left out.

    Raises GuestError for a name that the kernel does not have.
    """
    needs = dict(_needs(line) for line in (folder / "modules.dep").read_text().splitlines())
    built_in = {_name(path) for path in (folder / "modules.builtin").read_text().split()}
    paths = {_name(path): path for path in needs}
    order: dict[str, None] = {}

    def add(path: str) -> None:
        for other in needs[path]:
            add(other)
        order.setdefault(path)

    for name in wanted:
        if name in built_in:
            continue
        if name not in paths:
            raise GuestError(f"{folder.name}: this kernel has no module {name}")
        add(paths[name])
    return [(f"{_name(path)}.ko", _contents(folder / path)) for path in order]


def _needs(line: str) -> tuple[str, list[str]]:
    path, _, others = line.partition(":")
    return path, others.split()


def _name(path: str) -> str:
    return Path(path).name.partition(".")[0].replace("-", "_")


def _contents(path: Path) -> bytes:
    data = path.read_bytes()
    return lzma.decompress(data) if path.suffix == ".xz" else data
