"""The kernel's IIO devices as files: /sys/bus/iio/devices/iio:deviceN/ATTRIBUTE."""

import os
from collections.abc import Iterator
from errno import ENODEV, ENOTUNIQ
from pathlib import Path

from echogrid.drivers.bus import IioRead
from echogrid.drivers.errors import PortError

DEVICES = "iio:device*"
"""Triggers lie beside them."""
NAMES = ("label", "name")
"""What the device tree calls it (if it does), and what its kernel driver calls it."""
LONGEST = 4096
"""Bytes of an attribute, by the kernel's rule."""


class SysfsAdapter:
    """The folder of all IIO devices. Numbers change from one start of the machine to the next, so a device is
    looked up by any name that only it has, and again when it has gone."""

    def __init__(self, address: str) -> None:
        self._folder = Path(address)
        self._found: dict[str, Path] = {}
        self._opened = False

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        self._found.clear()
        self._require_folder("cannot open this IIO port: it is not there")
        self._opened = True

    def close(self) -> None:
        """Let go. May be called twice."""
        self._opened = False

    def transfer(self, transfer: IioRead) -> bytes:
        """The attribute's text. Raises PortError when there are no IIO devices any more, OSError when the
        read failed: ENODEV, there is no such device; ENOTUNIQ, there are several."""
        if not self._opened:
            raise PortError(f"{self._folder}: not open")
        folder = self._found.get(transfer.device) or self._find(transfer.device)
        try:
            return _read(folder / transfer.attribute)
        except FileNotFoundError:
            if folder.exists():
                raise
            del self._found[transfer.device]
            raise OSError(ENODEV, os.strerror(ENODEV)) from None

    def _find(self, device: str) -> Path:
        matching = [path for path in sorted(self._folder.glob(DEVICES)) if device in _names(path)]
        if len(matching) != 1:
            self._require_folder("IIO port lost")
            errno = ENOTUNIQ if matching else ENODEV
            raise OSError(errno, os.strerror(errno))
        self._found[device] = matching[0]
        return matching[0]

    def _require_folder(self, trouble: str) -> None:
        if self._folder.is_socket():
            raise PortError(f"{self._folder}: it is a socket: write unix:{self._folder}")
        if not self._folder.is_dir():
            mend = "load the ranger's kernel driver: sudo dtoverlay NAME, or sudo modprobe srf04"
            raise PortError(f"{self._folder}: {trouble} ({mend}; see docs/devices/kernel-iio.md)")


def _names(device: Path) -> Iterator[str]:
    """What a device is known by: its folder, what it hangs on (1-0070, hc-sr04-front), its names."""
    yield device.name
    yield device.resolve().parent.name
    for name in NAMES:
        try:
            yield _read(device / name).decode().strip()
        except (OSError, UnicodeError):
            continue


def _read(path: Path) -> bytes:
    """The text, by a single read: each one might ping."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        return os.read(descriptor, LONGEST)
    finally:
        os.close(descriptor)
