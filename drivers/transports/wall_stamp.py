"""The kernel's time stamps of frames, which are of the wall clock, brought to the monotonic one."""

import time
from collections.abc import Callable

LOOKS = 3
TOLERANCE_NS = 100_000
"""How far two looks at the clocks may differ before the wall clock is held to have moved."""


def wall_offset_ns() -> int:
    """How far the wall clock is ahead of the monotonic one, by the quickest of several looks."""
    return min(_look() for _ in range(LOOKS))[1]


def _look() -> tuple[int, int]:
    before_ns, wall_ns, after_ns = time.monotonic_ns(), time.time_ns(), time.monotonic_ns()
    return after_ns - before_ns, wall_ns - (before_ns + after_ns) // 2


class WallStamps:
    """Converts the stamps of one source, which come in order.

    The wall clock may be set at any time, and frames stamped before that still wait: a stamp that would lie
    in the future, or before the one that was given last, is taken by how the clocks stood before.
    """

    def __init__(self, offset_ns: Callable[[], int] = wall_offset_ns) -> None:
        self._look = offset_ns
        self._offset_ns = self._former_ns = offset_ns()
        self._latest_ns = 0

    def check(self) -> None:
        """Look at the clocks again. To be called before stamps which came in since."""
        offset_ns = self._look()
        if abs(offset_ns - self._offset_ns) > TOLERANCE_NS:
            self._former_ns, self._offset_ns = self._offset_ns, offset_ns

    def monotonic_ns(self, wall_ns: int, now_ns: int) -> int:
        """When it was stamped; `now_ns` if that cannot be told."""
        for offset_ns in (self._offset_ns, self._former_ns):
            stamp_ns = wall_ns - offset_ns
            if self._latest_ns - TOLERANCE_NS <= stamp_ns <= now_ns + TOLERANCE_NS:
                self._latest_ns = min(max(stamp_ns, self._latest_ns), now_ns)
                return self._latest_ns
        return now_ns
