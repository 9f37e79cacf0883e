"""A CAN adapter in the hands of a test: the kernel's own slcan driver makes an interface of it."""

import fcntl
import os
import pty
import select
import struct
import termios
import threading
import tty
from pathlib import Path
from typing import Self

from hil_tests.kernel import command, wait_for

N_SLCAN = 17
"""The line discipline, of linux/tty.h."""
LINKS = Path("/sys/class/net")
LOOK_S = 0.02


def links() -> set[str]:
    """The names of all network interfaces."""
    return {link.name for link in LINKS.iterdir()}


class SlcanAdapter:
    """Enter to plug it in. It takes what the kernel sends unless it is hung up, and says what a test wants.

    As a controller behind the kernel's driver it has a state, error counters and a queue, which vcan has not.
    """

    def __init__(self, interface: str, bitrate: int) -> None:
        self.interface = interface
        self.heard = bytearray()
        """What the kernel has sent."""
        self._bitrate = bitrate
        self._taking = threading.Event()
        self._plugged = True
        self._thread = threading.Thread(target=self._take, name="slcan adapter")

    def __enter__(self) -> Self:
        before = links()
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        fcntl.ioctl(self._slave, termios.TIOCSETD, struct.pack("i", N_SLCAN))
        (name,) = wait_for("a link of slcan", lambda: links() - before)
        command("ip", "link", "set", name, "name", self.interface)
        self._taking.set()
        self._thread.start()
        self.set_up()
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    def set_up(self) -> None:
        """Set the link up, as the kernel's driver allows it: without restart-ms."""
        command("ip", "link", "set", self.interface, "up", "type", "can", "bitrate", str(self._bitrate))

    def say(self, *lines: str) -> None:
        """What an adapter says: "t0012AABB" a frame, "sp000130" a state and its counters, "e1a" an error."""
        os.write(self._master, "".join(f"{line}\r" for line in lines).encode())

    def hang(self) -> None:
        """Take nothing more of what is sent."""
        self._taking.clear()

    def go_on(self) -> None:
        """The end of that."""
        self._taking.set()

    def unplug(self) -> None:
        """Pull it: its interface goes. May be called twice."""
        if self._plugged:
            self._plugged = False
            self._taking.set()
            self._thread.join()
            os.close(self._master)
            os.close(self._slave)

    def _take(self) -> None:
        while self._plugged:
            self._taking.wait()
            ready, _, _ = select.select([self._master], [], [], LOOK_S)
            if ready and self._taking.is_set():
                self.heard += os.read(self._master, 1 << 16)
