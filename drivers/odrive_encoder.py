"""In which of its messages an ODrive tells where its encoder stands: as an estimate or as a count."""

from collections import Counter
from math import isfinite
from typing import Protocol

from echogrid.drivers.cansimple import COUNTS, ESTIMATES, decode_counts, decode_estimates
from echogrid.drivers.counter import CountedWheel, Scale
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.wheel_angle import WheelAngle

COUNTER_BITS = 32
STAMP_ERROR_NS = 1_000_000
"""A full bus holds a frame back for about two others."""


class Encoder(Protocol):
    """One kind of message with positions, made into readings."""

    command: int
    counts: Counter[str]
    mend: str
    """What to look at if none come."""

    def lost(self) -> None:
        """The controller may have restarted."""
        ...

    def restarted(self) -> None:
        """The controller may have zeroed its position."""
        ...

    def take(self, stamp_ns: int, data: bytes, heartbeat_ns: int) -> tuple[WheelReading, ...]:
        """The reading that its 8 bytes make; none if they are not believed, which is counted."""
        ...


class Estimates:
    """Position and velocity in float32: 0.0 where they are not known."""

    command = ESTIMATES
    mend = "is encoder_rate_ms (with 0.6 encoder_msg_rate_ms) set?"

    def __init__(self, role: WheelRole) -> None:
        self.counts: Counter[str] = Counter()
        self._name = role.name
        self._angle = WheelAngle(role.gear, role.fastest, role.steering)
        self._turns = 0.0
        self._zeros_ns: int | None = None
        self._gap = False
        self._restarted = False

    def lost(self) -> None:
        """The controller may have restarted."""
        self._gap = True

    def restarted(self) -> None:
        """The controller may have zeroed its position."""
        self._restarted = True

    def take(self, stamp_ns: int, data: bytes, heartbeat_ns: int) -> tuple[WheelReading, ...]:
        """The reading that its 8 bytes make."""
        turns, rate = decode_estimates(data)
        if reason := self._doubt(stamp_ns, turns, rate) or self._sudden(stamp_ns, turns, rate, heartbeat_ns):
            self.counts[reason] += 1
            return ()
        advance = self._angle.advance(stamp_ns, turns, rate, self._gap, self._restarted)
        if advance is None:
            self.counts["doubtful jumps"] += 1
            return ()
        angle, jumped = advance
        self._turns = turns
        self._gap = self._restarted = False
        self.counts["readings"] += 1
        self.counts["discontinuities"] += jumped
        wheel_rate = self._angle.rate(rate)
        return (WheelReading(stamp_ns, STAMP_ERROR_NS, self._name, angle, wheel_rate, jumped, data),)

    def _doubt(self, stamp_ns: int, turns: float, rate: float) -> str:
        """Why an estimate is not believed; empty if it is."""
        if not (isfinite(turns) and isfinite(rate)):
            return "estimates not finite"
        if not self._angle.believable(turns, rate):
            return "estimates out of range"
        if not self._angle.precedes(stamp_ns):
            return "estimates out of order"
        return ""

    def _sudden(self, stamp_ns: int, turns: float, rate: float, heartbeat_ns: int) -> str:
        """Whether it reads like an encoder that failed since the last heartbeat: the next one will tell."""
        if turns or rate or not self._turns:
            self._zeros_ns = None
            return ""
        if self._zeros_ns is None:
            self._zeros_ns = stamp_ns
        return "estimates suddenly zero" if heartbeat_ns <= self._zeros_ns else ""


class Counts:
    """The count since power-up: exact however far it is, wrapping at 2^31. It comes without a velocity."""

    command = COUNTS
    mend = "is encoder_count_rate_ms set?"

    def __init__(self, role: WheelRole, counts_per_turn: int) -> None:
        self._wheel = CountedWheel(role, Scale(1 << COUNTER_BITS, counts_per_turn))
        self.counts = self._wheel.counts

    def lost(self) -> None:
        """The controller may have restarted."""
        self._wheel.lost()

    def restarted(self) -> None:
        """The controller may have zeroed its count."""
        self._wheel.restarted()

    def take(self, stamp_ns: int, data: bytes, heartbeat_ns: int) -> tuple[WheelReading, ...]:  # noqa: ARG002 - as every encoder is told
        """The reading that its 8 bytes make."""
        return self._wheel.read(stamp_ns, decode_counts(data)[0], data)
