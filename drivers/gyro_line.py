"""Lines of text with a number in each, as a microcontroller prints them."""

import re
from collections.abc import Iterator
from math import nan

LONGEST = 256
"""Bytes of a line."""
_END = re.compile(rb"[\r\n]+")
_NUMBER = re.compile(rb"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_PRINTED = re.compile(rb"[\t\x20-\x7e]*")
_NO_NUMBERS = (b"nan", b"inf", b"ovf")
"""How C libraries and Arduino's print what is none."""

Number = tuple[float, bytes]
"""NaN where a word stands for what is no number; and the whole line."""


class LineFinder:
    """Finds the number in each line: in the column that is told, or in the one which begins with the key.

    What comes before the first end of a line is not looked at: half a line is another number.
    """

    def __init__(self, separator: str, column: int, key: str) -> None:
        """A separator of blanks is any run of them. `column` counts from 1."""
        self._separator = separator.strip().encode() or None
        self._column = column
        self._key = key.encode()
        self._pending: bytes | None = None
        """The line under way; None: it began before one was listening, or is too long."""
        self.bad_lines = 0

    def feed(self, chunk: bytes) -> list[Number]:
        """The numbers of the lines which `chunk` completes. Between calls it keeps one line at most."""
        return [number for line in self._lines(chunk) if (number := self._number(line)) is not None]

    def forget(self) -> None:
        """Start anew, as after a pause in the stream."""
        self._pending = None

    def _lines(self, chunk: bytes) -> Iterator[bytes]:
        first, *others = _END.split(chunk)
        for end in others:
            if self._pending is not None and (line := self._pending + first):
                yield line
            self._pending, first = b"", end
        if self._pending is not None:
            self._pending += first
            if len(self._pending) > LONGEST:
                self.bad_lines += 1
                self._pending = None

    def _number(self, line: bytes) -> Number | None:
        """What the line says, if it is one of those that are meant."""
        word = self._word(line) if _PRINTED.fullmatch(line) else None
        if word is not None and _NUMBER.fullmatch(word):
            return float(word), line
        if word is not None and word.lstrip(b"+-").lower() in _NO_NUMBERS:
            return nan, line
        self.bad_lines += 1
        return None

    def _word(self, line: bytes) -> bytes | None:
        words = [word.strip() for word in line.split(self._separator)]
        if self._key:
            return next((w.removeprefix(self._key).strip() for w in words if w.startswith(self._key)), None)
        return words[self._column - 1] if len(words) >= self._column else None
