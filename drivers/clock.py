"""Time as an argument: the machine's monotonic clock, and one that jumps."""

import time
from typing import Protocol


class Clock(Protocol):
    """Integer nanoseconds which never go back."""

    def now_ns(self) -> int:
        """The time now."""
        ...

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """Return when the deadline has come; at once if it is past."""
        ...


class MonotonicClock:
    """CLOCK_MONOTONIC, shared by every process of the machine."""

    def now_ns(self) -> int:
        """The time now."""
        return time.monotonic_ns()

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """Return when the deadline has come; at once if it is past."""
        while (left_ns := deadline_ns - time.monotonic_ns()) > 0:
            time.sleep(left_ns * 1e-9)


class JumpingClock:
    """A clock which moves only when told, so that simulated hours pass in seconds and always alike."""

    def __init__(self, start_ns: int = 0) -> None:
        self._now_ns = start_ns

    def now_ns(self) -> int:
        """The time now."""
        return self._now_ns

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """Jump to the deadline, unless it is past."""
        self._now_ns = max(self._now_ns, deadline_ns)
