import struct
import zlib

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from echogrid.runtime import png


def decode(data: bytes) -> NDArray[np.uint8]:
    """The pixels of an 8 bit RGB image whose lines are not filtered; every checksum is checked."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    chunks: dict[bytes, bytes] = {}
    place = 8
    while place < len(data):
        (length,) = struct.unpack_from(">I", data, place)
        kind, body = data[place + 4 : place + 8], data[place + 8 : place + 8 + length]
        (checksum,) = struct.unpack_from(">I", data, place + 8 + length)
        assert checksum == zlib.crc32(kind + body)
        chunks[kind] = chunks.get(kind, b"") + body
        place += 12 + length
    assert list(chunks) == [b"IHDR", b"IDAT", b"IEND"]
    cols, rows, depth, colour, *rest = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    assert (depth, colour, rest) == (8, 2, [0, 0, 0])
    lines = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(rows, 1 + 3 * cols)
    assert not lines[:, 0].any()
    return lines[:, 1:].reshape(rows, cols, 3)


@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 2**32 - 1))
def test_what_is_encoded_is_decoded(rows: int, cols: int, seed: int) -> None:
    pixels = np.random.default_rng(seed).integers(0, 256, (rows, cols, 3), np.uint8)
    np.testing.assert_array_equal(decode(png.encode(pixels)), pixels)


def test_a_view_that_is_upside_down_is_encoded_as_it_is_seen() -> None:
    pixels = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)[::-1]
    np.testing.assert_array_equal(decode(png.encode(pixels)), pixels)
