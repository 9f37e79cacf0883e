"""How old what the robot knows of its surroundings is, as measured."""

from collections import deque
from collections.abc import Iterable

from echogrid.drivers.readings import Outcome, RangeReading

_WINDOW_NS = 2_000_000_000


class Latency:
    """The longest time that a reading of the last two seconds needed, from the sound's echo to its tick."""

    def __init__(self) -> None:
        self.newest_ns = 0
        """When the newest echo, or silence, that was told so far was heard; 0 before the first."""
        self._ages: deque[tuple[int, int]] = deque()

    def take(self, readings: Iterable[RangeReading], now_ns: int) -> None:
        """Readings that this tick took in."""
        for reading in readings:
            if reading.outcome is not Outcome.INVALID and not reading.listened:
                self.newest_ns = max(self.newest_ns, min(reading.stamp_ns, now_ns))
                self._add(now_ns, max(now_ns - reading.stamp_ns, 0))
        while self._ages and now_ns - self._ages[0][0] > _WINDOW_NS:
            self._ages.popleft()

    @property
    def worst_ns(self) -> int:
        """0 while there is nothing to measure."""
        return self._ages[0][1] if self._ages else 0

    def _add(self, now_ns: int, age_ns: int) -> None:
        """The ages that are kept fall, so that the first is the longest."""
        while self._ages and self._ages[-1][1] <= age_ns:
            self._ages.pop()
        self._ages.append((now_ns, age_ns))
