"""Telling when a step took much longer than the steps before it."""

from collections import deque
from statistics import median

_MANY = 3
"""Usual intervals: from two lost readings in a row on."""
_KEPT = 15
_FEWEST = 3


class GapWatch:
    """Compares each interval with the usual one, the median of the last 15."""

    def __init__(self) -> None:
        self._intervals: deque[int] = deque(maxlen=_KEPT)

    def is_gap(self, interval_ns: int) -> bool:
        """Whether this interval is longer than three usual ones; it is remembered. The first are no gaps."""
        known = len(self._intervals) >= _FEWEST
        result = known and interval_ns > _MANY * median(self._intervals)
        self._intervals.append(interval_ns)
        return result
