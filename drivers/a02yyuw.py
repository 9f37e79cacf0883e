"""DFRobot A02YYUW and its kin (A01NYUB, ME007YS, JSN-SR04T by serial): they ping and send unasked."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import nan
from typing import ClassVar

from echogrid.drivers.device import Health, Level, Step
from echogrid.drivers.ff_frame import LENGTH, Frame, FrameFinder
from echogrid.drivers.limits import require_between
from echogrid.drivers.readings import Outcome, RangeReading, classify
from echogrid.drivers.role import RangerRole

BITS_PER_BYTE = 10
"""8 data bits, a start and a stop bit."""
STALE_NS = 1_000_000_000


class A02yyuw:
    """One ranger that is only listened to. Its frame is believed when the one before adjoins it."""

    bus: ClassVar[str] = "serial"
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
        self.name = role.name
        self.port_options: Mapping[str, object] = {"baud": settings.baud}
        self._role = role
        self._settings = settings
        self._frames = FrameFinder(frozenset(settings.no_echo_mm + settings.invalid_mm))
        transfer_ns = LENGTH * BITS_PER_BYTE * 1_000_000_000 // settings.baud
        self._delay_ns = transfer_ns + round(settings.lag_ms * 1e6)
        self._error_ns = round(settings.lag_error_ms * 1e6)
        self._counts: Counter[str] = Counter()
        self._heard_ns: int | None = None
        self._believed_ns: int | None = None
        self._latest: RangeReading | None = None

    def step(self, now_ns: int, received: Sequence[bytes]) -> Step[bytes]:
        """Take the bytes that arrived now.

        Of several frames only the last gives a reading: nobody knows how long the others were held up.
        """
        chunk = b"".join(received)
        if chunk:
            self._heard_ns = now_ns
        believed = [frame for frame in self._frames.feed(chunk) if self._believe(frame)]
        if not believed:
            return Step()
        self._counts["overtaken frames"] += len(believed) - 1
        self._believed_ns = now_ns
        self._latest = self._reading(believed[-1], now_ns - self._delay_ns)
        self._counts[self._latest.outcome.value] += 1
        return Step((self._latest,))

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """The port was lost."""
        self._frames.forget()

    def health(self, now_ns: int) -> Health:
        """How it is."""
        level, message = self._condition(now_ns)
        finder = {"bad frames": self._frames.false_headers, "skipped bytes": self._frames.skipped_bytes}
        return Health(level, message, dict(self._counts) | finder)

    def _condition(self, now_ns: int) -> tuple[Level, str]:
        if self._heard_ns is None or now_ns - self._heard_ns > STALE_NS:
            return Level.STALE, "silent: check its power and TX wire; some parts are silent without an echo"
        if self._believed_ns is None or now_ns - self._believed_ns > STALE_NS:
            return (
                Level.ERROR,
                f"bytes, but no frames: does it send at {self._settings.baud} baud, not inverted?",
            )
        if self._latest is not None and self._latest.outcome is Outcome.INVALID:
            return Level.WARN, f"invalid reading: {self._latest.reason}"
        return Level.OK, "ranging"

    def _believe(self, frame: Frame) -> bool:
        if not frame.adjoining:
            self._counts["unconfirmed frames"] += 1
        return frame.adjoining

    def _reading(self, frame: Frame, stamp_ns: int) -> RangeReading:
        outcome, distance = self._meaning(frame.millimetres)
        reason = f"code {frame.millimetres:#06x}" if outcome is Outcome.INVALID else ""
        return RangeReading(stamp_ns, self._error_ns, self.name, outcome, distance, frame.raw, reason)

    def _meaning(self, millimetres: int) -> tuple[Outcome, float]:
        if millimetres in self._settings.no_echo_mm:
            return Outcome.NO_ECHO, nan
        if millimetres in self._settings.invalid_mm:
            return Outcome.INVALID, nan
        return classify(millimetres / 1000, self._role.nearest, self._role.farthest)
