"""A yaw gyro behind a microcontroller that prints a line of text for each rate."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers.device import Health, Line, State, Step
from echogrid.drivers.freshness import is_old
from echogrid.drivers.gyro_line import LineFinder
from echogrid.drivers.limits import require_between
from echogrid.drivers.role import GyroRole
from echogrid.drivers.streaming import BITS_PER_BYTE, NOTHING
from echogrid.drivers.yaw_gyro import GyroSettings, YawGyro


@dataclass(frozen=True, slots=True)
class GyroTextSettings(GyroSettings):
    """Its keys in a config file."""

    baud: int = 115_200
    separator: str = ","
    """Between the columns of a line; " ": any blanks."""
    column: int = 1
    """Which of them holds the number, counted from 1."""
    key: str = ""
    """What stands before the number in its column, such as "gz="; then the column may be any."""

    def __post_init__(self) -> None:
        GyroSettings.__post_init__(self)
        require_between("baud", self.baud, 1200, 4_000_000)
        require_between("column", self.column, 1, 64)
        for name, text in (("separator", self.separator), ("key", self.key)):
            if len(text) > 16 or not (text.isascii() and text.replace("\t", " ").isprintable()):
                raise ValueError(f"{name} is {text!r}: expected up to 16 ASCII characters")
        if not self.separator:
            raise ValueError('separator is empty: expected such as "," or " "')
        if self.key != self.key.strip():
            raise ValueError(f"key is {self.key!r}: it has blanks around it")
        if self.key and self.column != 1:
            raise ValueError("column and key: give one of them")


class GyroText(YawGyro):
    """One gyro that is only listened to. A lost byte makes another number of a line, and nothing shows it."""

    bus: ClassVar[str] = "serial"
    line: ClassVar[type[Line[bytes, bytes]]] = Line
    identity: ClassVar[str] = ""
    Settings = GyroTextSettings

    def __init__(self, role: GyroRole, settings: GyroTextSettings) -> None:
        super().__init__(role, settings)
        self.port_options: Mapping[str, object] = {"baud": settings.baud}
        self._baud = settings.baud
        self._wanted = f"a number after {settings.key!r}" if settings.key else f"column {settings.column}"
        self._lines = LineFinder(settings.separator, settings.column, settings.key)
        self._byte_ns = BITS_PER_BYTE * 1_000_000_000 // settings.baud
        self._said_ns: int | None = None
        """When a whole line came last."""
        self._awaited_ns = 0
        """Since when there are bytes."""

    def step(self, now_ns: int, received: Sequence[bytes]) -> Step[bytes]:
        """Take the bytes that arrived now.

        Of several lines only the last gives a reading: nobody knows how long the others were held up.
        """
        if not received:
            return NOTHING
        if self._silent(now_ns):
            self._lines.forget()
            self._awaited_ns = now_ns
        self._heard_ns = now_ns
        numbers = self._lines.feed(b"".join(received))
        if not numbers:
            return NOTHING
        if len(numbers) > 1:
            self._counts["overtaken lines"] += len(numbers) - 1
        self._said_ns = now_ns
        number, raw = numbers[-1]
        return Step(self._read(now_ns - (len(raw) + 1) * self._byte_ns, number, raw))

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """The port was lost."""
        self._heard_ns = None
        self._lines.forget()

    def health(self, now_ns: int) -> Health:
        """How it is."""
        state, message = self._condition(now_ns)
        return Health(state, message, {**self._counts, "bad lines": self._lines.bad_lines})

    def _condition(self, now_ns: int) -> tuple[State, str]:
        if self._silent(now_ns):
            return State.SILENT, "nothing comes: check power and TX wire, and that it prints by itself"
        if is_old(max(self._said_ns or 0, self._awaited_ns), now_ns):
            what = f"bytes, but no lines with {self._wanted}"
            return State.GARBLED, f"{what}: is it {self._baud} baud, are separator, column and key right?"
        if self._said_ns is None or is_old(self._said_ns, now_ns):
            return State.SETTING_UP, "bytes come, no whole line yet"
        if not self._believed(now_ns):
            return (
                State.FAULTY,
                "its numbers are none, or above fastest_dps: look at the gyro, its range, unit and scale",
            )
        return State.WELL, "turning measured"
