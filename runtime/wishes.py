"""Where somebody says how the robot shall move: a datagram socket, or a joystick. Neither ever waits.

A wish is what is wanted, not what is done: the guard passes on the safe part of it.
"""

import json
import os
import socket
import struct
from collections import Counter
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Protocol

from echogrid.mapping.twist import Twist

FRESH_NS = 300_000_000
"""A wish that is not repeated within this is none."""
STANDSTILL = Twist()

_LONGEST = 512
"""Bytes of a datagram."""
_MOST = 64
"""Datagrams, or joystick events, that are read at a time: who floods us must not keep the loop."""


class Wishes(Protocol):
    """A source of twists."""

    refused: Counter[str]
    """What came and was no wish, by reason."""

    def poll(self, now_ns: int) -> Twist:
        """What is wanted now; to stand, if nobody wants anything, or nobody can be heard."""
        ...

    def close(self) -> None:
        """Let the source go."""
        ...


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
            return Twist(*map(float, numbers))
    except OverflowError:  # JSON has integers that no float holds.
        pass
    raise ValueError("not two finite numbers")


def unix_socket(path: Path) -> socket.socket:
    """Bound to that path; a socket left there by an earlier run is replaced. Raises OSError, also if anything
    else is there."""
    if path.is_socket():
        path.unlink()
    return _bound(socket.AF_UNIX, str(path))


def udp_socket(port: int, host: str = "127.0.0.1") -> socket.socket:
    """Bound to that port, of this machine alone unless another host is given. Raises OSError."""
    return _bound(socket.AF_INET, (host, port))


def _bound(family: socket.AddressFamily, address: str | tuple[str, int]) -> socket.socket:
    heard = socket.socket(family, socket.SOCK_DGRAM)
    try:
        heard.bind(address)
    except OSError:
        heard.close()
        raise
    return heard


@dataclass(frozen=True, slots=True)
class JoystickLayout:
    """What of a joystick means what; the numbers are the kernel's (`jstest` shows them)."""

    forward_axis: int = 1
    """Pushed away it is negative, and that is ahead."""
    turn_axis: int = 0
    """To the left it is negative, and that is counter-clockwise."""
    hold_button: int = 4
    """Held while the robot may move: a dead man's button."""
    most_speed: float = 0.5
    """m/s, at full deflection."""
    most_turn_rate: float = 1.5
    """rad/s."""


class JoystickWishes:
    """A joystick by the kernel's interface (linux/joystick.h): 8 bytes an event, /dev/input/js0 and so on.

    An unplugged one is no wish; plugged in again, it is opened again. Its state is told anew then, so that a
    button held meanwhile counts.
    """

    _EVENT = struct.Struct("<IhBB")
    _BUTTON, _AXIS, _INITIAL = 1, 2, 0x80
    _FULL = 32767.0
    _AGAIN_NS = 500_000_000

    def __init__(self, path: Path, layout: JoystickLayout) -> None:
        self.refused: Counter[str] = Counter()
        self._path = path
        self._layout = layout
        self._file: int | None = None
        self._again_ns = 0
        self._axes: dict[int, float] = {}
        self._held = False

    def poll(self, now_ns: int) -> Twist:
        """What its sticks say while the button is held."""
        if self._file is None and now_ns >= self._again_ns:
            self._open(now_ns)
        if self._file is not None:
            self._read(self._file)
        if self._file is None or not self._held:
            return STANDSTILL
        ahead = -self._axes.get(self._layout.forward_axis, 0.0)
        left = -self._axes.get(self._layout.turn_axis, 0.0)
        return Twist(ahead * self._layout.most_speed, left * self._layout.most_turn_rate)

    def close(self) -> None:
        """Let it go; nothing is held any more."""
        if self._file is not None:
            os.close(self._file)
        self._file, self._held = None, False
        self._axes.clear()

    def _open(self, now_ns: int) -> None:
        self._again_ns = now_ns + self._AGAIN_NS
        try:
            self._file = os.open(self._path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError:
            self.refused["joystick not there"] += 1

    def _read(self, file: int) -> None:
        try:
            data = os.read(file, _MOST * self._EVENT.size)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self.refused["joystick lost"] += 1
            self.close()
        for _, value, kind, number in self._EVENT.iter_unpack(data[: len(data) // 8 * 8]):
            kind &= ~self._INITIAL
            if kind == self._AXIS:
                self._axes[number] = max(value / self._FULL, -1.0)
            elif kind == self._BUTTON and number == self._layout.hold_button:
                self._held = value != 0
