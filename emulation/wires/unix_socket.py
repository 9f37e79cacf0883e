"""Listening on a Unix socket in the file system."""

import socket
from pathlib import Path

from echogrid.emulation.errors import DirectoryError

_LONGEST_PATH = 107


def listen(path: Path, kind: socket.SocketKind) -> socket.socket:
    """A listening socket that never blocks; a stale one at that path is replaced. Raises DirectoryError."""
    if len(bytes(path)) > _LONGEST_PATH:
        raise DirectoryError(
            f"{path}: too long for a socket, at most {_LONGEST_PATH} bytes (use a shorter directory)"
        )
    path.unlink(missing_ok=True)
    listener = socket.socket(socket.AF_UNIX, kind)
    listener.setblocking(False)
    listener.bind(str(path))
    listener.listen()
    return listener
