"""What to do about a port that will not open."""

import termios
from errno import (
    EACCES,
    EAFNOSUPPORT,
    EAGAIN,
    EBUSY,
    ECONNREFUSED,
    EIO,
    EISDIR,
    ENODEV,
    ENOENT,
    ENOTTY,
    ENXIO,
    EPERM,
)
from pathlib import Path

from echogrid.drivers.errors import PortError

MISSING = {ENOENT, ENODEV, ENXIO, EIO}
FORBIDDEN = {EACCES, EPERM}
TAKEN = {EBUSY, EAGAIN}


def cannot_open(kind: str, address: str, group: str, error: Exception) -> PortError:
    """The error for a port of that kind and address which could not be opened because of `error`."""
    cause = _mistaken(kind, address) or _cause(kind, address, group, error)
    return PortError(f"{address}: cannot open this {kind} port: {cause}")


def errno_of(error: BaseException | None) -> int | None:
    """The errno of the error, or of the nearest one behind it that has any."""
    while error is not None:
        code = error.args[0] if isinstance(error, termios.error) else getattr(error, "errno", None)
        if isinstance(code, int):
            return code
        error = error.__cause__ or error.__context__
    return None


def _mistaken(kind: str, address: str) -> str | None:
    """What stands there in place of a port, where the errno alone would mislead."""
    if not kind.endswith("socket") and Path(address).is_socket():
        return f"it is a socket: write unix:{address}" if kind == "I2C" else _no(kind)
    return None


def _cause(kind: str, address: str, group: str, error: Exception) -> str:
    code = errno_of(error)
    if code in MISSING:
        return "it is not there (is it plugged in, and its path right?)"
    if code == EISDIR:
        return "it is a folder"
    if code == ENOTTY:
        return _no(kind)
    if code in FORBIDDEN:
        return f"no permission (sudo usermod -aG {group} $USER, then log in again)"
    if code in TAKEN:
        return f"another program holds it (find it with: fuser -v {address}, and stop it)"
    if code == EAFNOSUPPORT:
        return "this kernel has no CAN (try: sudo modprobe can-raw)"
    if code == ECONNREFUSED:
        return "nobody answers there (is the emulator running?)"
    return str(error)


def _no(kind: str) -> str:
    """A CAN adapter of which a file is the port is one on a serial port."""
    return "it is no I2C bus" if kind == "I2C" else "it is no serial port"
