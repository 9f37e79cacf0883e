"""Whether a controller that counts its milliseconds has restarted between two of its messages."""

COUNTER = 1 << 32
"""Its counter wraps there."""
SLACK_MS = 20
DRIFT = 0.05
"""Its clock may be so much faster or slower than ours."""


class Uptime:
    """Compares its counter with our clock."""

    def __init__(self) -> None:
        self._last: tuple[int, int] | None = None

    def restarted(self, stamp_ns: int, milliseconds: int) -> bool:
        """Whether it has, since the message before: it counted less than went by, and may have begun since.

        What merely came late has counted less, too, but for long.
        """
        last, self._last = self._last, (stamp_ns, milliseconds)
        if last is None:
            return False
        passed_ms = (stamp_ns - last[0]) * 1e-6
        slack_ms = SLACK_MS + DRIFT * abs(passed_ms)
        counted_ms = (milliseconds - last[1] + COUNTER // 2) % COUNTER - COUNTER // 2
        return counted_ms < passed_ms - slack_ms and milliseconds % COUNTER <= passed_ms + slack_ms
