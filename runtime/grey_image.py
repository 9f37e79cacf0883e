"""The pictures in which maps are kept, PGM and PNG, as shades of grey."""

import re
import struct
import zlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_PGM = re.compile(rb"P([25])(?:\s|#[^\n]*\n)+(\d+)(?:\s|#[^\n]*\n)+(\d+)(?:\s|#[^\n]*\n)+(\d+)\s")
_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""By PNG's colour type."""
_PALETTE = 3
_LARGEST = 20_000
"""Pixels along a side."""
_MOST = 40_000_000
"""Pixels in all: as many as a map may have cells."""


class GreyImageError(Exception):
    """It can't be read, and why."""


def read_grey(data: bytes) -> Floats:
    """(rows, cols) 0 black to 1 white, row 0 on top. Raises GreyImageError."""
    try:
        return _png(data) if data.startswith(_SIGNATURE) else _pgm(data)
    except (ValueError, OverflowError, IndexError, StopIteration, struct.error, zlib.error) as error:
        raise GreyImageError(f"is a damaged picture: {error}") from error


def _pgm(data: bytes) -> Floats:
    head = _PGM.match(data)
    if head is None:
        raise GreyImageError("is neither a PGM nor a PNG")
    cols, rows, white = (int(head[group]) for group in (2, 3, 4))
    _check_size(rows, cols)
    if not 0 < white < 1 << 16:
        raise GreyImageError("has an impossible depth")
    body = data[head.end() :]
    if head[1] == b"2":
        values = np.array(body.split()[: rows * cols], np.int64)
    else:
        values = np.frombuffer(body, np.uint8 if white < 256 else ">u2", rows * cols)
    if values.min() < 0 or values.max() > white:
        raise GreyImageError(f"has shades outside 0...{white}")
    result: Floats = values.reshape(rows, cols) / white
    return result


def _png(data: bytes) -> Floats:
    chunks = list(_chunks(data))
    cols, rows, depth, kind, _, _, interlaced = struct.unpack_from(">IIBBBBB", chunks[0][1])
    _check_size(rows, cols)
    if depth != 8 or interlaced or kind not in _CHANNELS:
        raise GreyImageError("is a PNG of an unusual kind: save it with 8 bits, not interlaced")
    channels = _CHANNELS[kind]
    size = rows * (cols * channels + 1)
    unpacked = _unpacked(b"".join(body for name, body in chunks if name == b"IDAT"), size)
    lines = np.frombuffer(unpacked, np.uint8, size).reshape(rows, -1)
    pixels = _unfiltered(lines, channels).reshape(rows, cols, channels)
    if kind == _PALETTE:
        palette = next(body for name, body in chunks if name == b"PLTE")
        pixels = np.frombuffer(palette, np.uint8).reshape(-1, 3)[pixels[:, :, 0]]
    colours = pixels[:, :, :3] if pixels.shape[2] > 2 else pixels[:, :, :1]
    result: Floats = colours.mean(axis=2) / 255.0
    return result


def _check_size(rows: int, cols: int) -> None:
    if not (0 < rows <= _LARGEST and 0 < cols <= _LARGEST and rows * cols <= _MOST):
        raise GreyImageError(f"has an impossible size: {cols} x {rows} pixels")


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    place = len(_SIGNATURE)
    while place < len(data):
        length, name = struct.unpack_from(">I4s", data, place)
        yield name, data[place + 8 : place + 8 + length]
        place += length + 12


def _unpacked(packed: bytes, size: int) -> bytes:
    """So many bytes at most, however many more there would be."""
    return zlib.decompressobj().decompress(packed, size + 1)[:size]


def _unfiltered(lines: Pixels, channels: int) -> Pixels:
    """(rows, bytes) of (rows, 1 + bytes): each row is told by its filter's number, and by its differences
    from the pixels to the left and above."""
    result = np.zeros((lines.shape[0] + 1, lines.shape[1] - 1 + channels), np.uint8)
    for row, line in enumerate(lines, 1):
        result[row, channels:] = _row(int(line[0]), line[1:], result[row - 1], channels)
    return result[1:, channels:]


def _row(kind: int, told: Pixels, above: Pixels, channels: int) -> Pixels:
    """A row from its differences; the row above has a black pixel more to the left."""
    if kind == 0:
        return told
    if kind == 1:
        return np.cumsum(told.reshape(-1, channels), axis=0, dtype=np.uint8).ravel()
    if kind == 2:
        return told + above[channels:]
    if kind not in _GUESSES:
        raise ValueError(f"no filter {kind}")
    guess = _GUESSES[kind]
    row = bytearray(channels)  # Each byte needs the one before: numbers of Python are the fastest here.
    for difference, up, corner in zip(
        told.tolist(), above[channels:].tolist(), above[:-channels].tolist(), strict=True
    ):
        row.append((difference + guess(row[-channels], up, corner)) & 255)
    return np.frombuffer(row, np.uint8)[channels:]


def _mean(left: int, up: int, _corner: int) -> int:
    return (left + up) // 2


def _paeth(left: int, up: int, corner: int) -> int:
    """Of left, above and the corner between whichever is nearest to left + above - corner."""
    to_left, to_up, to_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
    if to_left <= to_up and to_left <= to_corner:
        return left
    return up if to_up <= to_corner else corner


_GUESSES = {3: _mean, 4: _paeth}
