"""The frame `FF H L SUM` of a family of serial rangers: H L is the distance in mm, SUM sums up the rest."""

from collections.abc import Iterator
from dataclasses import dataclass

HEADER = 0xFF
LENGTH = 4
LONGEST_MM = 10_000
"""No part of the family measures more. Without this bound a steady 511 mm (FF 01 FF FF) that is taken up
at its last byte (FF FF 01 FF) would be misread for ever."""


def decode(frame: bytes) -> int | None:
    """The frame's mm; None if it is not one."""
    if len(frame) != LENGTH or frame[0] != HEADER or sum(frame[:3]) & 0xFF != frame[3]:
        return None
    return int.from_bytes(frame[1:3], "big")


@dataclass(frozen=True, slots=True)
class Frame:
    """One valid frame."""

    millimetres: int
    raw: bytes
    adjoining: bool
    """Nothing but valid frames between it and the one before."""


class FrameFinder:
    """Finds frames in a stream, starting anew at the byte behind a header that proves false."""

    def __init__(self, codes: frozenset[int]) -> None:
        self._codes = codes
        self._pending = b""
        self._adjoining = False
        self.false_headers = 0
        self.skipped_bytes = 0

    def feed(self, chunk: bytes) -> Iterator[Frame]:
        """The frames which `chunk` completes. Between calls it keeps three bytes at most."""
        stream = self._pending + chunk
        start = self._next_header(stream, 0)
        while start + LENGTH <= len(stream):
            raw = stream[start : start + LENGTH]
            millimetres = decode(raw)
            if millimetres is not None and self._possible(millimetres):
                yield Frame(millimetres, raw, self._adjoining)
                self._adjoining = True
                start = self._next_header(stream, start + LENGTH)
            else:
                self.false_headers += 1
                self._skip(1)
                start = self._next_header(stream, start + 1)
        self._pending = stream[start:]

    def forget(self) -> None:
        """Start anew, as after a pause in the stream."""
        self._pending = b""
        self._adjoining = False

    def _possible(self, millimetres: int) -> bool:
        return millimetres <= LONGEST_MM or millimetres in self._codes

    def _next_header(self, stream: bytes, start: int) -> int:
        found = stream.find(HEADER, start)
        header = len(stream) if found < 0 else found
        self._skip(header - start)
        return header

    def _skip(self, count: int) -> None:
        if count:
            self.skipped_bytes += count
            self._adjoining = False
