"""Datagrams to one address, on this machine or another.

Sending never waits, and nothing that goes wrong with it is an error: it is counted by its reason.
"""

import errno
import socket
from collections import Counter
from collections.abc import Callable
from ipaddress import ip_address

from echogrid.mapping.virtual_sensor import ObstacleView
from echogrid.runtime.outputs.pace import Pace

Format = Callable[[ObstacleView, int], bytes]
"""From a view and its sequence number."""
Address = str | tuple[str, int]
"""A path, or an IP address and a port."""

_REASONS = {
    errno.ENOENT: "no receiver",
    errno.ECONNREFUSED: "no receiver",
    errno.EAGAIN: "receiver too slow",
    errno.ENOBUFS: "queue full",
    errno.EACCES: "not allowed",
    errno.EPERM: "not allowed",
    errno.EMSGSIZE: "too long",
    errno.ENETDOWN: "unreachable",
    errno.ENETUNREACH: "unreachable",
    errno.EHOSTUNREACH: "unreachable",
}


class DatagramOutput:
    """Sends views in one format. The socket is made with the first one."""

    def __init__(self, name: str, address: Address, form: Format, pace: Pace) -> None:
        self.name = name
        self.sent = 0
        self.dropped: Counter[str] = Counter()
        self._address = address
        self._form = form
        self._pace = pace
        self._sequence = 0
        self._socket: socket.socket | None = None

    def put(self, view: ObstacleView) -> None:
        """Send it, if it is time. What can't be sent has used up its number: the receiver sees a gap."""
        if not self._pace.due(view):
            return
        data = self._form(view, self._sequence)
        self._sequence += 1
        try:
            self._send(data)
        except OSError as error:
            number = error.errno or 0
            self.dropped[_REASONS.get(number, errno.errorcode.get(number, "lost"))] += 1
        else:
            self.sent += 1

    def close(self) -> None:
        """Let the socket go. May be called twice."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _send(self, data: bytes) -> None:
        if self._socket is None:
            self._socket = _made(self._address)
        if isinstance(self._address, str):
            self._socket.sendto(data, self._address)
        else:
            self._socket.send(data)


def _made(address: Address) -> socket.socket:
    """Connected where it can be: only then the kernel tells that nobody listens. A path may be bound anew."""
    if isinstance(address, str):
        made = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        made.setblocking(False)
        return made
    family = socket.AF_INET6 if ip_address(address[0]).version == 6 else socket.AF_INET
    made = socket.socket(family, socket.SOCK_DGRAM)
    made.setblocking(False)
    try:
        made.connect(address)
    except OSError:
        made.close()
        raise
    return made
