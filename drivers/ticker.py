"""Something that is sent at even intervals."""

from echogrid.drivers.bus import NEVER_NS


class Ticker:
    """Says when it is time. After a stall it skips what was missed."""

    def __init__(self, period_ns: int) -> None:
        self.deadline_ns = NEVER_NS
        """The next time; NEVER_NS while it is stopped."""
        self._period_ns = period_ns

    def start(self, now_ns: int) -> None:
        """From now on; nothing, if it runs already."""
        if self.deadline_ns == NEVER_NS:
            self.deadline_ns = now_ns

    def stop(self) -> None:
        """No more."""
        self.deadline_ns = NEVER_NS

    def due(self, now_ns: int) -> bool:
        """Whether it is time; once for each interval."""
        if now_ns < self.deadline_ns:
            return False
        self.deadline_ns += self._period_ns * ((now_ns - self.deadline_ns) // self._period_ns + 1)
        return True
