"""Replies that stayed away and may still come."""

from collections import Counter, deque

LATE_NS = 300_000_000
"""For so long after it was given up."""


class Owed:
    """Who owes how many replies."""

    def __init__(self) -> None:
        self._debts: deque[tuple[int, int]] = deque()
        """Until when, and by which device; the oldest first."""

    def add(self, device: int, count: int, now_ns: int) -> None:
        """So many replies of a device were given up now."""
        self._debts.extend([(now_ns + LATE_NS, device)] * count)

    def most(self, now_ns: int) -> int:
        """The most that one device still owes."""
        while self._debts and self._debts[0][0] <= now_ns:
            self._debts.popleft()
        return max(Counter(debtor for _, debtor in self._debts).values()) if self._debts else 0

    def clear(self) -> None:
        """Nothing can come any more."""
        self._debts.clear()
