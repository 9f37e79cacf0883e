"""Bytes on their way over one wire of a serial line."""

from collections import deque

from echogrid.drivers.bus import NEVER_NS

_SECOND_NS = 1_000_000_000


class Transmitter:
    """One direction of a line: each byte takes its bits and is there when the last one has passed."""

    def __init__(self, baud: int, bits_per_byte: int = 10) -> None:
        """`bits_per_byte` counts start, data, parity and stop bits."""
        self._baud = baud
        self._bits = bits_per_byte
        self._free_ns = 0
        self._bytes: deque[tuple[int, int]] = deque()

    def send(self, data: bytes, start_ns: int) -> None:
        """Send from `start_ns` on, or when the line is free."""
        start_ns = max(start_ns, self._free_ns)
        for count, byte in enumerate(data, start=1):
            self._free_ns = start_ns + count * self._bits * _SECOND_NS // self._baud
            self._bytes.append((self._free_ns, byte))

    def pause(self, start_ns: int, duration_ns: int) -> int:
        """Keep the line busy without bytes, from `start_ns` or when it is free; until when."""
        self._free_ns = max(start_ns, self._free_ns) + duration_ns
        return self._free_ns

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
