"""Telling the service manager how it goes, by systemd's protocol; where there is none, nothing is told."""

import contextlib
import os
import socket
from collections.abc import Mapping


class ServiceManager:
    """Whoever started the service and watches over it. No message waits or fails: the loop must go on."""

    def __init__(self, address: str | None) -> None:
        """`address` is that of its socket: a path, or @ and an abstract name."""
        abstract = address is not None and address.startswith("@")
        self._address = f"\0{address[1:]}" if address and abstract else address

    @classmethod
    def of(cls, environment: Mapping[str, str] = os.environ) -> "ServiceManager":
        """The one which that environment names, if it names any."""
        return cls(environment.get("NOTIFY_SOCKET"))

    @property
    def listens(self) -> bool:
        """Whether there is one."""
        return bool(self._address)

    def ready(self) -> None:
        """The service does its work from now on."""
        self._tell("READY=1")

    def alive(self, status: str) -> None:
        """The loop turns, and how it goes. To be told by the loop itself, more often than WatchdogSec."""
        self._tell(f"WATCHDOG=1\nSTATUS={' '.join(status.split())}")

    def stopping(self) -> None:
        """The service has begun to end."""
        self._tell("STOPPING=1")

    def _tell(self, message: str) -> None:
        if not self._address:
            return
        with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as client:
            client.setblocking(False)
            client.sendto(message.encode(), self._address)
