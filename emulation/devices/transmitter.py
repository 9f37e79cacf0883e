"""Bytes on their way over one wire of a serial line."""

from collections import deque

from echogrid.drivers.bus import NEVER_NS

_BITS_PER_BYTE = 10
_SECOND_NS = 1_000_000_000


class Transmitter:
    """One direction of a line: 8N1, so each byte takes ten bits and is there when the last one has passed."""

    def __init__(self, baud: int) -> None:
        self._baud = baud
        self._free_ns = 0
        self._bytes: deque[tuple[int, int]] = deque()

    def send(self, data: bytes, start_ns: int) -> None:
        """Send from `start_ns` on, or when the line is free."""
        start_ns = max(start_ns, self._free_ns)
        for count, byte in enumerate(data, start=1):
            self._free_ns = start_ns + count * _BITS_PER_BYTE * _SECOND_NS // self._baud
            self._bytes.append((self._free_ns, byte))

    def take(self, now_ns: int) -> bytes:
        """The bytes which have passed whole by now, each given once."""
        passed = bytearray()
        while self._bytes and self._bytes[0][0] <= now_ns:
            passed.append(self._bytes.popleft()[1])
        return bytes(passed)

    def next_ns(self) -> int:
        """When the next byte will have passed; NEVER_NS if none is on its way."""
        return self._bytes[0][0] if self._bytes else NEVER_NS

    def stop(self) -> None:
        """Lose what is on its way."""
        self._bytes.clear()
        self._free_ns = 0
