"""A datagram socket on which somebody says how the robot shall move. It is never waited for."""

import json
import socket
from collections import Counter
from math import isfinite
from pathlib import Path

from echogrid.mapping.twist import Twist
from echogrid.runtime.wishes import FRESH_NS, STANDSTILL

_LONGEST = 512
"""Bytes of a datagram."""
_FASTEST, _SLOWEST = 100.0, 1e-6
"""m/s and rad/s: what is more is a mistake, what is less is none."""
_MOST = 64
"""Datagrams that are read at a time: who floods us must not keep the loop."""


class SocketWishes:
    """JSON objects by Unix datagrams or UDP: {"speed": 0.3, "turn_rate": -0.1}, in m/s and rad/s."""

    def __init__(self, heard: socket.socket) -> None:
        """`heard` is bound already; it is closed with this."""
        self.refused: Counter[str] = Counter()
        self._socket = heard
        self._latest: tuple[int, Twist] | None = None
        heard.setblocking(False)

    def poll(self, now_ns: int) -> Twist:
        """The newest wish, if it is fresh."""
        for _ in range(_MOST):
            try:
                data = self._socket.recv(_LONGEST + 1)
            except OSError:
                break
            self._take(data, now_ns)
        else:  # What would stop the robot may be among those that wait, or were lost.
            self._latest = None
            self.refused["flooded"] += 1
        fresh = self._latest is not None and now_ns - self._latest[0] <= FRESH_NS
        return self._latest[1] if self._latest and fresh else STANDSTILL

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()

    def _take(self, data: bytes, now_ns: int) -> None:
        try:
            self._latest = now_ns, read_wish(data)
        except ValueError as error:
            self.refused[str(error)] += 1


def read_wish(data: bytes) -> Twist:
    """The twist of a datagram. Raises ValueError with the reason for what is none."""
    if len(data) > _LONGEST:
        raise ValueError("too long")
    try:
        fields = json.loads(data)
    except (ValueError, RecursionError):
        raise ValueError("no JSON") from None
    if not isinstance(fields, dict) or fields.keys() != {"speed", "turn_rate"}:
        raise ValueError("not an object with speed and turn_rate")
    numbers = [fields["speed"], fields["turn_rate"]]
    try:
        if all(type(number) in (int, float) and isfinite(number) for number in numbers):
            return Twist(*(_sane(float(number)) for number in numbers))
    except OverflowError:  # JSON has integers that no float holds.
        pass
    raise ValueError("not two finite numbers")


def _sane(value: float) -> float:
    if abs(value) > _FASTEST:
        raise ValueError("more than 100 m/s or rad/s")
    return value if abs(value) >= _SLOWEST else 0.0


def unix_socket(path: Path) -> socket.socket:
    """Bound to that path; a socket left there by an earlier run is replaced. Raises OSError, also if anything
    else is there, or somebody hears there."""
    if path.is_socket() and not _is_heard(path):
        path.unlink()
    return _bound(socket.AF_UNIX, str(path))


def udp_socket(port: int, host: str = "127.0.0.1") -> socket.socket:
    """Bound to that port, of this machine alone unless another host is given. Raises OSError, and
    OverflowError for what is no port."""
    return _bound(socket.AF_INET, (host, port))


def _is_heard(path: Path) -> bool:
    """Whether a socket belongs to a process that lives."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(str(path))
        except ConnectionRefusedError:
            return False
    return True


def _bound(family: socket.AddressFamily, address: str | tuple[str, int]) -> socket.socket:
    heard = socket.socket(family, socket.SOCK_DGRAM)
    try:
        heard.bind(address)
    except (OSError, OverflowError):
        heard.close()
        raise
    return heard
