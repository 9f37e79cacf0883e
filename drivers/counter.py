"""A wheel from the counter of a controller, which wraps at its ends and begins at zero after a restart."""

from collections import Counter
from dataclasses import dataclass
from math import tau

from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.wheel_angle import SLACK_S, WheelAngle

RESTART_NS = 300_000_000
"""A controller which restarts is silent for longer than that."""
STAMP_ERROR_NS = 1_000_000
"""A full bus holds a frame back for about two others."""


def difference(new: int, old: int, modulus: int) -> int:
    """How far a counter went that wraps after `modulus` counts: the shortest way, in [-modulus/2, modulus/2).

    For a counter of n bits it is ((new - old + 2^(n-1)) mod 2^n) - 2^(n-1).
    """
    half = modulus // 2
    return (new - old + half) % modulus - half


@dataclass(frozen=True, slots=True)
class Scale:
    """How a controller counts."""

    modulus: int
    """Counts from one wrap to the next: 2^n for a counter of n bits."""
    per_turn: float
    """Counts for one turn of the encoder."""


@dataclass(frozen=True, slots=True)
class _Count:
    stamp_ns: int
    count: int
    unwrapped: int


class CountedWheel:
    """Counts -> readings. What it can't be sure of it reports as a discontinuity, with zero motion.

    Such are: a pause in which the counter could have gone more than half way round; a pause in which the
    controller may have restarted, if from zero the wheel could have come to the new count; a restart that is
    known; and a jump that no wheel can do, once a second count confirms it.

    Of steering, a count means the angle nearest to straight ahead that has it, whatever was before; a
    discontinuity then says only that nobody knows how it turned meanwhile.
    """

    def __init__(self, role: WheelRole, scale: Scale) -> None:
        self.counts: Counter[str] = Counter()
        self.believed_ns: int | None = None
        """When the latest count came that was believed."""
        self.rebased_ns: int | None = None
        """When the first count came, or the latest discontinuity."""
        self._name = role.name
        self._scale = scale
        self._angle = WheelAngle(role.gear, role.fastest, role.steering, coarseness=0.0)
        self._fastest = role.fastest * abs(role.gear) / tau * scale.per_turn
        self._ahead = _count_ahead(role, scale.per_turn)
        self._last: _Count | None = None
        self._rate = 0.0
        self._heard_ns: int | None = None
        self._gap = False
        self._restarted = False

    def heard(self, stamp_ns: int) -> None:
        """Any frame of the controller has come: it may have restarted in a long pause before it."""
        self._gap |= self._heard_ns is not None and stamp_ns - self._heard_ns > RESTART_NS
        self._heard_ns = stamp_ns

    def lost(self) -> None:
        """The port was lost: the controller may have restarted meanwhile."""
        self._gap = True

    def restarted(self) -> None:
        """The controller says that it has restarted, or its counts have lost their meaning otherwise."""
        self._restarted = True

    def read(
        self, stamp_ns: int, count: int, raw: bytes, rate: float | None = None
    ) -> tuple[WheelReading, ...]:
        """The reading that a count makes; none if the count is not believed, which is counted.

        `rate` is the encoder's, turns/s, if the controller tells it; else it is the mean since the last one.
        """
        if not self._angle.precedes(stamp_ns):
            self.counts["counts out of order"] += 1
            return ()
        latest = _Count(stamp_ns, count, self._unwrapped(count))
        turns = latest.unwrapped / self._scale.per_turn
        if not self._angle.reaches(turns):
            self.counts["angles out of range"] += 1
            return ()
        rebased = self._restarted or self._uncertain(latest)
        advance = self._angle.advance(stamp_ns, turns, 0.0, restarted=rebased)
        if advance is None:
            self.counts["doubtful jumps"] += 1
            return ()
        angle, jumped = advance
        self._rate = self._rate_at(latest, jumped, rate)
        self._keep(latest, jumped)
        wheel_rate = self._angle.rate(self._rate)
        return (WheelReading(stamp_ns, STAMP_ERROR_NS, self._name, angle, wheel_rate, jumped, raw),)

    def _keep(self, latest: _Count, jumped: bool) -> None:
        if jumped or self._last is None:
            self.rebased_ns = latest.stamp_ns
        self._last = latest
        self.believed_ns = latest.stamp_ns
        self._gap = self._restarted = False
        self.counts["readings"] += 1
        self.counts["discontinuities"] += jumped

    def _unwrapped(self, count: int) -> int:
        if self._ahead is not None:
            return self._ahead + difference(count, self._ahead, self._scale.modulus)
        if self._last is None:
            return count
        return self._last.unwrapped + difference(count, self._last.count, self._scale.modulus)

    def _uncertain(self, latest: _Count) -> bool:
        """Whether the way since the last count is a guess."""
        if self._last is None:
            return False
        pause_s = (latest.stamp_ns - self._last.stamp_ns) * 1e-9
        reach = self._fastest * (pause_s + SLACK_S)
        return 2 * reach >= self._scale.modulus or (self._gap and abs(latest.count) <= reach)

    def _rate_at(self, latest: _Count, jumped: bool, told: float | None) -> float:
        if told is not None and self._angle.keeps_up(told):
            return told
        if self._last is None or jumped:
            return 0.0
        if latest.stamp_ns == self._last.stamp_ns:
            return self._rate
        turns = (latest.unwrapped - self._last.unwrapped) / self._scale.per_turn
        mean = turns / (latest.stamp_ns - self._last.stamp_ns) * 1e9
        return mean if self._angle.keeps_up(mean) else self._rate  # stamps may be closer than the counts were


def _count_ahead(role: WheelRole, per_turn: float) -> int | None:
    """The count at which steering stands straight ahead; None for a wheel that rolls."""
    return None if role.steering is None else round(role.steering.zero * role.gear / tau * per_turn)
