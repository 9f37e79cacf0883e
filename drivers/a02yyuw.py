"""DFRobot A02YYUW and its kin (A01NYUB, ME007YS, JSN-SR04T by serial): they ping and send unasked."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers.device import Line
from echogrid.drivers.ff_frame import LENGTH, Frame, FrameFinder
from echogrid.drivers.limits import require_between
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole
from echogrid.drivers.streaming import BITS_PER_BYTE, Said, StreamingRanger


class A02yyuwMake:
    """What it sends. A frame is believed when the one before adjoins it: the header occurs in data, too."""

    def __init__(self, settings: "A02yyuw.Settings") -> None:
        self._settings = settings
        self._frames = FrameFinder(frozenset(settings.no_echo_mm + settings.invalid_mm))
        self._unconfirmed = 0
        transfer_ns = LENGTH * BITS_PER_BYTE * 1_000_000_000 // settings.baud
        self.delay_ns = transfer_ns + round(settings.lag_ms * 1e6)
        self.error_ns = round(settings.lag_error_ms * 1e6)
        self.garbled = f"does it send at {settings.baud} baud, not inverted?"

    def feed(self, chunk: bytes) -> Iterator[Said]:
        """The believed frames."""
        for frame in self._frames.feed(chunk):
            if frame.adjoining:
                yield self._said(frame)
            else:
                self._unconfirmed += 1

    def forget(self) -> None:
        """Start anew."""
        self._frames.forget()

    def counts(self) -> Mapping[str, int]:
        """What was not believed."""
        return {
            "bad frames": self._frames.false_headers,
            "skipped bytes": self._frames.skipped_bytes,
            "unconfirmed frames": self._unconfirmed,
        }

    def _said(self, frame: Frame) -> Said:
        if frame.millimetres in self._settings.no_echo_mm:
            return Said(frame.raw, Outcome.NO_ECHO)
        if frame.millimetres in self._settings.invalid_mm:
            return Said(frame.raw, Outcome.INVALID, reason=f"code {frame.millimetres:#06x}")
        return Said(frame.raw, Outcome.ECHO, frame.millimetres / 1000)


class A02yyuw(StreamingRanger):
    """One ranger that is only listened to."""

    bus: ClassVar[str] = "serial"
    line: ClassVar[type[Line[bytes, bytes]]] = Line
    identity: ClassVar[str] = ""

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        baud: int = 9600
        lag_ms: float = 200.0
        """From the sound meeting the obstacle to the first byte. The data sheet says 100 to 300 ms for
        the filtered value (RX open), 100 ms for the real-time one (RX low)."""
        lag_error_ms: float = 100.0
        no_echo_mm: tuple[int, ...] = (0, 0xFFFD)
        """What this part sends when nothing is heard: 0, newer ones 0xFFFD, some their longest distance."""
        invalid_mm: tuple[int, ...] = (0xFFFE,)
        """What this part sends when its measurement failed: newer ones 0xFFFE, interference."""

        def __post_init__(self) -> None:
            require_between("baud", self.baud, 1200, 921_600)
            require_between("lag_ms", self.lag_ms, 0.0, 2000.0)
            require_between("lag_error_ms", self.lag_error_ms, 0.0, 2000.0)
            for code in self.no_echo_mm:
                require_between("no_echo_mm", code, 0, 0xFFFF)
            for code in self.invalid_mm:
                require_between("invalid_mm", code, 0, 0xFFFF)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, A02yyuwMake(settings))
        self.port_options: Mapping[str, object] = {"baud": settings.baud}
