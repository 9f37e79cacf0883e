"""The frame `FF H L SUM` of a family of serial rangers: H L is the distance in mm, SUM sums up the rest."""

from collections.abc import Container

HEADER = 0xFF
LENGTH = 4
LONGEST_MM = 10_000
"""No part of the family measures more. Without this bound a steady 511 mm (FF 01 FF FF) that is taken up
at its last byte (FF FF 01 FF) would be misread for ever."""


Frame = tuple[int, bytes, bool]
"""A valid frame's mm, its bytes, and whether it adjoins: the four bytes before it are a valid frame, too."""


def decode(frame: bytes, header_summed: bool = True) -> int | None:
    """The frame's mm; None if it is not one. Some boards sum up H and L only."""
    if len(frame) != LENGTH:
        return None
    header, high, low, total = frame
    if header != HEADER or (high + low + header * header_summed - total) & 0xFF:
        return None
    return high << 8 | low


class FrameFinder:
    """Finds every frame in a stream, overlapping ones as well, so that nothing hides what comes behind it:
    of two frames sent one after the other the second is found, and adjoins, whatever was before them.

    The header occurs in data. But a false frame adjoins another only by the rarest chance: a steady distance
    never looks like one, and a changing one only if it falls by 1024 mm twice running, from L = FF.
    """

    def __init__(self, codes: Container[int], header_summed: bool = True) -> None:
        """`codes` are the values that are no distances."""
        self._codes = codes
        self._header_summed = header_summed
        self._pending = b""
        self._position = 0
        self._ends = [-1] * LENGTH
        self._covered = 0
        self._framed = 0
        self.false_headers = 0

    @property
    def skipped_bytes(self) -> int:
        """How many bytes were in no frame."""
        return max(self._position, self._covered) - self._framed

    def feed(self, chunk: bytes) -> list[Frame]:
        """The frames which `chunk` completes. Between calls it keeps three bytes at most."""
        stream = self._pending + chunk
        frames: list[Frame] = []
        last = len(stream) - LENGTH
        start = stream.find(HEADER)
        while 0 <= start <= last:
            raw = stream[start : start + LENGTH]
            place, end = self._position + start, self._position + start + LENGTH
            millimetres = decode(raw, self._header_summed)
            if millimetres is not None and (millimetres <= LONGEST_MM or millimetres in self._codes):
                frames.append((millimetres, raw, self._ends[place % LENGTH] == place))
                self._ends[place % LENGTH] = end
                self._framed += LENGTH if place >= self._covered else end - self._covered
                self._covered = end
            elif place >= self._covered:
                self.false_headers += 1
            start = stream.find(HEADER, start + 1)
        kept = start if start >= 0 else len(stream)
        self._pending = stream[kept:]
        self._position += kept
        return frames

    def forget(self) -> None:
        """Start anew, as after a pause in the stream."""
        self._pending = b""
        self._ends = [-1] * LENGTH
