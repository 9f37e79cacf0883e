"""The fixed-rate loop: absolute deadlines, missed ticks skipped and counted, never made up for."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from echogrid.drivers.clock import Clock

SECOND_NS = 1_000_000_000


@dataclass(slots=True)
class FixedRateLoop:
    """Yields the time of each tick. A tick is in time when it starts within half a period of its deadline
    and ends before the next one."""

    clock: Clock
    rate_hz: float
    in_time: int = 0
    late: int = 0
    skipped: int = 0
    worst_ns: int = 0
    """The longest that a tick started after its deadline."""
    _period_ns: int = field(init=False)

    def __post_init__(self) -> None:
        self._period_ns = round(SECOND_NS / self.rate_hz)

    @property
    def punctuality(self) -> float:
        """The part of all due ticks that were in time; 1 before the first."""
        due = self.in_time + self.late + self.skipped
        return self.in_time / due if due else 1.0

    def ticks(self, until_ns: int) -> Iterator[int]:
        """The time at which each tick starts, from one period on, to the last deadline before `until_ns`."""
        deadline_ns = self.clock.now_ns() + self._period_ns
        while deadline_ns < until_ns:
            self.clock.sleep_until_ns(deadline_ns)
            start_ns = self.clock.now_ns()
            yield start_ns
            deadline_ns = self._account(deadline_ns, start_ns, self.clock.now_ns())

    def _account(self, deadline_ns: int, start_ns: int, end_ns: int) -> int:
        """Count the tick; the next deadline that can still be kept."""
        lateness_ns = start_ns - deadline_ns
        self.worst_ns = max(self.worst_ns, lateness_ns)
        if 2 * lateness_ns <= self._period_ns and end_ns <= deadline_ns + self._period_ns:
            self.in_time += 1
        else:
            self.late += 1
        slept_over = max(lateness_ns, 0) // self._period_ns
        next_ns = deadline_ns + (slept_over + 1) * self._period_ns
        overrun = max(end_ns - next_ns, 0) // self._period_ns
        self.skipped += slept_over + overrun
        return next_ns + overrun * self._period_ns
