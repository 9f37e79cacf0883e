"""The pictures in which maps are kept, PGM and PNG, as shades of grey."""

import re
import struct
import zlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_PGM = re.compile(rb"P([25])(?:\s+|#[^\n]*\n)+(\d+)(?:\s+|#[^\n]*\n)+(\d+)(?:\s+|#[^\n]*\n)+(\d+)\s")
_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""By PNG's colour type."""
_PALETTE = 3
_LARGEST = 20_000
"""Pixels along a side."""


class GreyImageError(Exception):
    """It can't be read, and why."""


def read_grey(data: bytes) -> Floats:
    """(rows, cols) 0 black to 1 white, row 0 on top. Raises GreyImageError."""
    try:
        return _png(data) if data.startswith(_SIGNATURE) else _pgm(data)
    except (ValueError, IndexError, StopIteration, struct.error, zlib.error) as error:
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
        values = np.frombuffer(body, np.uint8 if white < 256 else ">u2", rows * cols).astype(np.int64)
    result: Floats = values.reshape(rows, cols) / white
    return result


def _png(data: bytes) -> Floats:
    chunks = list(_chunks(data))
    cols, rows, depth, kind, _, _, interlaced = struct.unpack_from(">IIBBBBB", chunks[0][1])
    _check_size(rows, cols)
    if depth != 8 or interlaced or kind not in _CHANNELS:
        raise GreyImageError("is a PNG of an unusual kind: save it with 8 bits, not interlaced")
    packed = zlib.decompress(b"".join(body for name, body in chunks if name == b"IDAT"))
    pixels = _unfiltered(packed, rows, cols, _CHANNELS[kind])
    if kind == _PALETTE:
        palette = next(body for name, body in chunks if name == b"PLTE")
        pixels = np.frombuffer(palette, np.uint8).reshape(-1, 3)[pixels[:, :, 0]]
    colours = pixels[:, :, :3] if pixels.shape[2] > 2 else pixels[:, :, :1]
    result: Floats = colours.mean(axis=2) / 255.0
    return result


def _check_size(rows: int, cols: int) -> None:
    if not (0 < rows <= _LARGEST and 0 < cols <= _LARGEST):
        raise GreyImageError("has an impossible size")


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    place = len(_SIGNATURE)
    while place < len(data):
        length, name = struct.unpack_from(">I4s", data, place)
        yield name, data[place + 8 : place + 8 + length]
        place += length + 12


def _unfiltered(packed: bytes, rows: int, cols: int, channels: int) -> Pixels:
    """(rows, cols, channels): each row is told by its differences from the pixels to the left and above."""
    lines = np.frombuffer(packed, np.uint8, rows * (cols * channels + 1)).reshape(rows, -1)
    result = np.zeros((rows + 1, cols + 1, channels), np.uint8)
    for row, line in enumerate(lines, 1):
        told = line[1:].reshape(cols, channels)
        if line[0] == 0:
            result[row, 1:] = told
        elif line[0] == 2:
            result[row, 1:] = told + result[row - 1, 1:]
        else:
            _unfilter(int(line[0]), told, result[row - 1], result[row])
    return result[1:, 1:]


def _unfilter(kind: int, told: Pixels, above: Pixels, row: Pixels) -> None:
    """Of the filters that look to the left: 1 left, 3 the mean of left and above, 4 Paeth's choice."""
    for col, differences in enumerate(told.astype(np.int64), 1):
        left, up, corner = (each.astype(np.int64) for each in (row[col - 1], above[col], above[col - 1]))
        if kind == 1:
            guess = left
        elif kind == 3:
            guess = (left + up) // 2
        elif kind == 4:
            guess = _paeth(left, up, corner)
        else:
            raise ValueError(f"no filter {kind}")
        row[col] = (differences + guess) & 255


def _paeth(left: NDArray[np.int64], up: NDArray[np.int64], corner: NDArray[np.int64]) -> NDArray[np.int64]:
    """Of left, above and the corner between whichever is nearest to left + above - corner."""
    to_left, to_up, to_corner = np.abs(up - corner), np.abs(left - corner), np.abs(left + up - 2 * corner)
    other = np.where(to_up <= to_corner, up, corner)
    return np.where((to_left <= to_up) & (to_left <= to_corner), left, other)
