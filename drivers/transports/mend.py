"""What to do about a port that will not open."""

from errno import EACCES, EAFNOSUPPORT, EAGAIN, EBUSY, ECONNREFUSED, EIO, ENODEV, ENOENT, ENXIO, EPERM

from echogrid.drivers.errors import PortError

MISSING = {ENOENT, ENODEV, ENXIO, EIO}
FORBIDDEN = {EACCES, EPERM}
TAKEN = {EBUSY, EAGAIN}


def cannot_open(kind: str, address: str, group: str, error: Exception, code: int | None) -> PortError:
    """The error for a port of that kind and address which could not be opened because of `code`."""
    return PortError(f"{address}: cannot open this {kind} port: {_cause(group, error, code)}")


def _cause(group: str, error: Exception, code: int | None) -> str:
    if code in MISSING:
        return "it is not there (is it plugged in, and its path right?)"
    if code in FORBIDDEN:
        return f"no permission (sudo usermod -aG {group} $USER, then log in again)"
    if code in TAKEN:
        return "another program holds it (find it with: fuser -v PATH, and stop it)"
    if code == EAFNOSUPPORT:
        return "this kernel has no CAN (try: sudo modprobe can-raw)"
    if code == ECONNREFUSED:
        return "nobody answers there (is the emulator running?)"
    return str(error)
