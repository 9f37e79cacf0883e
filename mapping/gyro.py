"""A yaw rate gyro: how far the robot turned by it, free of the bias that shows while the robot stands."""

from bisect import bisect_left, bisect_right

_KEEP_NS = 10_000_000_000
WIDEST_GAP_NS = 250_000_000
"""Rates further apart say nothing of what was between."""
_FEWEST_S = 0.5
"""Standing for so long shows the bias."""
_MEMORY_S = 30.0
"""The bias drifts with temperature: it follows what was seen in so many seconds of standing."""


class Gyro:
    """The integral of the rates, by the trapezoid rule. Stamps rise."""

    def __init__(self) -> None:
        self.bias = 0.0
        """rad/s, as it reads when nothing turns."""
        self._stood_s = 0.0
        self._stamps: list[int] = []
        self._rates: list[float] = []
        self._sums: list[float] = []

    def add(self, stamp_ns: int, rate: float) -> bool:
        """Take a rate (rad/s, counter-clockwise); False, and nothing taken, unless it is the newest."""
        if self._stamps and stamp_ns <= self._stamps[-1]:
            return False
        total = 0.0
        if self._stamps:
            seconds = (stamp_ns - self._stamps[-1]) * 1e-9
            total = self._sums[-1] + seconds * (self._rates[-1] + rate) / 2.0
        self._stamps.append(stamp_ns)
        self._rates.append(rate)
        self._sums.append(total)
        self._forget()
        return True

    @property
    def settled(self) -> bool:
        """Whether the bias is known."""
        return self._stood_s >= _FEWEST_S

    def turned(self, start_ns: int, end_ns: int) -> float | None:
        """The turn (rad) between two stamps, less the bias; None where the rates don't cover all of it."""
        raw = self._raw(start_ns, end_ns)
        return None if raw is None else raw - self.bias * (end_ns - start_ns) * 1e-9

    def stood(self, start_ns: int, end_ns: int) -> None:
        """Learn the bias: the robot stood between these stamps."""
        raw = self._raw(start_ns, end_ns)
        if raw is None:
            return
        seconds = (end_ns - start_ns) * 1e-9
        self._stood_s = min(self._stood_s + seconds, _MEMORY_S)
        weight = min(1.0, seconds / self._stood_s)
        self.bias += weight * (raw / seconds - self.bias)

    def _raw(self, start_ns: int, end_ns: int) -> float | None:
        stamps = self._stamps
        if not stamps or start_ns < stamps[0] or end_ns > stamps[-1] or start_ns >= end_ns:
            return None
        first, last = bisect_right(stamps, start_ns) - 1, bisect_left(stamps, end_ns)
        gaps = (
            after - before
            for before, after in zip(stamps[first:last], stamps[first + 1 : last + 1], strict=True)
        )
        if max(gaps) > WIDEST_GAP_NS:
            return None
        return self._sum_at(end_ns) - self._sum_at(start_ns)

    def _sum_at(self, stamp_ns: int) -> float:
        """The integral up to a stamp that is covered; between two rates they are taken as a straight line."""
        before = bisect_right(self._stamps, stamp_ns) - 1
        into_ns = stamp_ns - self._stamps[before]
        if not into_ns:
            return self._sums[before]
        whole_ns = self._stamps[before + 1] - self._stamps[before]
        start, end = self._rates[before], self._rates[before + 1]
        rate = start + (end - start) * into_ns / whole_ns
        return self._sums[before] + into_ns * 1e-9 * (start + rate) / 2.0

    def _forget(self) -> None:
        """Drop what is too old, a batch at a time."""
        if len(self._stamps) < 256:
            return
        old = bisect_right(self._stamps, self._stamps[-1] - _KEEP_NS) - 1
        if old > len(self._stamps) // 2:
            del self._stamps[:old], self._rates[:old], self._sums[:old]
