"""A joystick that says how the robot shall move, by the kernel's own interface. It is never waited for."""

import os
import struct
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from echogrid.mapping.twist import Twist
from echogrid.runtime.wishes import STANDSTILL

_MOST = 64
"""Events that are read at a time: who floods us must not keep the loop."""


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
