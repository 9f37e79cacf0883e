"""Readings on their way from the bus threads to the loop."""

import threading
from collections import deque

from echogrid.drivers.readings import Reading


class ReadingQueue:
    """Bounded: when full, the oldest reading gives way to the newest, and is handed out as overflow.

    Any number of threads may put; one may drain.
    """

    def __init__(self, most: int = 4096) -> None:
        self._most = most
        self._readings: deque[Reading] = deque()
        self._overflow: deque[Reading] = deque()
        self._lock = threading.Lock()

    def put(self, readings: tuple[Reading, ...]) -> None:
        """Append."""
        with self._lock:
            self._readings.extend(readings)
            while len(self._readings) > self._most:
                self._overflow.append(self._readings.popleft())

    def drain(self) -> list[Reading]:
        """All that is there, in order of arrival."""
        return self._emptied(self._readings)

    def drain_overflow(self) -> list[Reading]:
        """What had to give way since the last call."""
        return self._emptied(self._overflow)

    def _emptied(self, readings: deque[Reading]) -> list[Reading]:
        with self._lock:
            taken = list(readings)
            readings.clear()
        return taken
