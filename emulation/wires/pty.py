"""A serial line as a pseudo-terminal under a lasting name."""

import os
import select
import termios
import tty
from abc import abstractmethod
from collections.abc import Sequence
from pathlib import Path
from random import Random
from typing import TypeVar

from echogrid.drivers.bus import Break
from echogrid.drivers.clock import Clock
from echogrid.emulation.buses.bus import Bus
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.wires.loop import Loop
from echogrid.emulation.wires.wire import Wire

_CHUNK = 4096
_INPUT_SPEED, _OUTPUT_SPEED = 4, 5
"""Indices into what tcgetattr gives."""

In = TypeVar("In")
Out = TypeVar("Out")


class Pty:
    """The adapter's end of a pseudo-terminal, and a symbolic link to the client's end.

    Bytes for a client which is not there, or which does not read, are lost.
    """

    def __init__(self, link: Path, baud: int | None, unlike: str = "") -> None:
        """Make the terminal, raw, at that speed and not of the name `unlike`, and point the link at it."""
        self._link = link
        self.descriptor, client = _open_unlike(unlike)
        self.name = os.ttyname(client)
        self._rest = b""
        self._poll = select.poll()
        self._poll.register(self.descriptor, 0)
        tty.setraw(client)
        _set_speed(client, baud)
        os.close(client)
        os.set_blocking(self.descriptor, False)
        _point(link, self.name)

    def hang_up(self) -> None:
        """Take the port away from whoever has it open; the link goes too."""
        self._link.unlink(missing_ok=True)
        os.close(self.descriptor)

    def read(self) -> bytes:
        """All that the client has sent; b"" if nothing, or if there is no client."""
        data = bytearray()
        try:
            while chunk := os.read(self.descriptor, _CHUNK):
                data += chunk
        except OSError:  # EAGAIN: that was all; EIO: the client has closed.
            pass
        return bytes(data)

    def write(self, data: bytes) -> None:
        """Send to the client. Of what it leaves unread, whole writes are lost, never the middle of one."""
        if not self.has_client():
            self._rest = b""
            return
        if self._rest:
            self._rest = self._rest[self._write(self._rest) :]
        if not self._rest:
            written = self._write(data)
            self._rest = data[written:] if written else b""

    def has_client(self) -> bool:
        """Whether somebody has the port open."""
        return not self._poll.poll(0)

    def speed(self) -> int:
        """The speed that the client has set, as a constant of termios."""
        return int(termios.tcgetattr(self.descriptor)[_OUTPUT_SPEED])

    def _write(self, data: bytes) -> int:
        try:
            return os.write(self.descriptor, data)
        except OSError:  # EAGAIN: its buffer is full; EIO: it has just closed.
            return 0


class TerminalWire(Wire[In, Out]):
    """A bus behind a pseudo-terminal. After a hang-up it comes back as another one, under the same link."""

    def __init__(self, bus: Bus[In, Out], link: Path, clock: Clock, loop: Loop, baud: int | None) -> None:
        super().__init__(bus, clock, loop)
        self._link = link
        self._baud = baud
        self._last_name = ""

    def _attach(self) -> None:
        self._terminal = Pty(self._link, self._baud, unlike=self._last_name)
        self._last_name = self._terminal.name
        self._loop.watch(self._terminal.descriptor, self._receive, edge=True)

    def _detach(self) -> None:
        self._loop.unwatch(self._terminal.descriptor)
        self._terminal.hang_up()

    @abstractmethod
    def _receive(self) -> None:
        """Take what the client has sent."""


class SerialWire(TerminalWire[bytes, bytes | Break]):
    """A serial line whose client must set the right speed: else both sides read garbage. No breaks show."""

    def __init__(self, line: SerialLine, link: Path, clock: Clock, loop: Loop, random: Random) -> None:
        super().__init__(line, link, clock, loop, line.baud)
        line.lose_breaks()
        self._speed = _speed(line.baud)
        self._random = random

    def _receive(self) -> None:
        data = self._terminal.read()
        if data:
            self._send((self._heard(data),))

    def _deliver(self, items: Sequence[bytes]) -> None:
        self._terminal.write(self._heard(b"".join(items)))

    def _heard(self, data: bytes) -> bytes:
        """The bytes as they are read at the other side."""
        if self._speed in (None, self._terminal.speed()):
            return data
        return self._random.randbytes(len(data))


def _open_unlike(name: str) -> tuple[int, int]:
    """A new pair; the kernel gives a name that has become free at once to the next."""
    pair = os.openpty()
    if os.ttyname(pair[1]) != name:
        return pair
    other = os.openpty()
    for descriptor in pair:
        os.close(descriptor)
    return other


def _speed(baud: int | None) -> int | None:
    """The constant of termios; None if it has none for that speed."""
    speed: int | None = getattr(termios, f"B{baud}", None)
    return speed


def _set_speed(descriptor: int, baud: int | None) -> None:
    speed = _speed(baud)
    if speed is not None:
        attributes = termios.tcgetattr(descriptor)
        attributes[_INPUT_SPEED] = attributes[_OUTPUT_SPEED] = speed
        termios.tcsetattr(descriptor, termios.TCSANOW, attributes)


def _point(link: Path, target: str) -> None:
    """Make or turn a symbolic link, at once for whoever looks."""
    fresh = link.with_name(f".{link.name}.new")
    fresh.unlink(missing_ok=True)
    fresh.symlink_to(target)
    fresh.rename(link)
