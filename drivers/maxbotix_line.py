"""The line of MaxBotix rangers by serial: `R`, three or four digits, on some a space or ` P1`, and CR."""

import re

_TAIL = 4
"""Space, P, flag and CR at most."""

Line = tuple[int, bytes, bool | None]
"""The number, the whole line, and its presence flag if it has one."""


class LineFinder:
    """Finds the lines with exactly so many digits, whatever stands before and between them: noise, the text
    at power-up, lines that lost a digit."""

    def __init__(self, digits: int) -> None:
        self._pattern = re.compile(rb"(R([0-9]{%d})(?: (?:P([01]))?)?\r)" % digits)
        self._longest = 1 + digits + _TAIL
        self._pending = b""
        self.bad_lines = 0
        self.skipped_bytes = 0

    def feed(self, chunk: bytes) -> list[Line]:
        """The lines which `chunk` completes. Between calls it keeps the beginning of one at most."""
        stream = self._pending + chunk
        lines: list[Line] = []
        read = 0
        for raw, number, flag in self._pattern.findall(stream):
            lines.append((int(number), raw, flag == b"1" if flag else None))
            read += len(raw)
        self._pending = b"" if read == len(stream) else self._beginning(stream, lines)
        skipped = len(stream) - len(self._pending) - read
        if skipped:
            self.skipped_bytes += skipped
            self.bad_lines += stream.count(b"\r") - self._pending.count(b"\r") - len(lines)
        return lines

    def forget(self) -> None:
        """Start anew, as after a pause in the stream."""
        self._pending = b""

    def _beginning(self, stream: bytes, lines: list[Line]) -> bytes:
        """What may be the beginning of a line, behind those: none holds a second R, so only the last may."""
        end = stream.rfind(lines[-1][1]) + len(lines[-1][1]) if lines else 0
        start = stream.rfind(b"R", max(end, len(stream) - self._longest + 1))
        return stream[start:] if start >= 0 else b""
