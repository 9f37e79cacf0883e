import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from echogrid.runtime import png
from echogrid.runtime.grey_image import GreyImageError, read_grey

SIZES = st.tuples(st.integers(1, 9), st.integers(1, 9))


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def paeth(left: int, up: int, corner: int) -> int:
    """As the PNG specification has it, section 9.4."""
    p = left + up - corner
    near = [abs(p - left), abs(p - up), abs(p - corner)]
    return (left, up, corner)[near.index(min(near))]


def encoded(pixels: NDArray[np.uint8], colour: int, kinds: list[int], palette: bytes = b"") -> bytes:
    """A PNG whose rows are filtered as told, byte by byte as in the specification."""
    rows, cols, channels = pixels.shape
    data = bytearray()
    for row in range(rows):
        kind = kinds[row % len(kinds)]
        data.append(kind)
        for col in range(cols):
            for channel in range(channels):
                left = int(pixels[row, col - 1, channel]) if col else 0
                up = int(pixels[row - 1, col, channel]) if row else 0
                corner = int(pixels[row - 1, col - 1, channel]) if row and col else 0
                guess = (0, left, up, (left + up) // 2, paeth(left, up, corner))[kind]
                data.append((int(pixels[row, col, channel]) - guess) & 255)
    header = struct.pack(">IIBBBBB", cols, rows, 8, colour, 0, 0, 0)
    body = chunk(b"PLTE", palette) if palette else b""
    body += chunk(b"IDAT", zlib.compress(bytes(data)))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + body + chunk(b"IEND", b"")


@given(SIZES, st.sampled_from([0, 2, 4, 6]), st.lists(st.integers(0, 4), min_size=1), st.integers(0, 999))
def test_a_png_of_any_filters_is_read(
    size: tuple[int, int], colour: int, kinds: list[int], seed: int
) -> None:
    channels = {0: 1, 2: 3, 4: 2, 6: 4}[colour]
    pixels = np.random.default_rng(seed).integers(0, 256, (*size, channels)).astype(np.uint8)
    shades = pixels[:, :, :3] if channels > 2 else pixels[:, :, :1]
    read = read_grey(encoded(pixels, colour, kinds))
    np.testing.assert_allclose(read, shades.mean(axis=2) / 255.0)


def test_a_png_of_our_own_is_read() -> None:
    pixels = np.array([[[0, 0, 0], [255, 255, 255]], [[205, 205, 205], [51, 51, 51]]], np.uint8)
    np.testing.assert_allclose(read_grey(png.encode(pixels)), [[0.0, 1.0], [205 / 255, 0.2]])


def test_a_palette_s_colours_are_looked_up() -> None:
    places = np.array([[[1], [0]]], np.uint8)
    read = read_grey(encoded(places, 3, [0], palette=bytes([255, 255, 255, 0, 0, 0])))
    np.testing.assert_allclose(read, [[0.0, 1.0]])


@pytest.mark.parametrize(
    "data",
    [
        b"P5\n2 2\n255\n\x00\xff\xcd\x33",
        b"P5 # a remark\n2 2\n255\n\x00\xff\xcd\x33",
        b"P2\n2 2\n255\n0 255\n205 51\n",
        b"P5\n2 2\n65535\n" + np.array([0, 65535, 52685, 13107], ">u2").tobytes(),
    ],
)
def test_a_pgm_of_every_kind_is_read(data: bytes) -> None:
    np.testing.assert_allclose(read_grey(data), [[0.0, 1.0], [205 / 255, 0.2]])


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"GIF89a",
        b"P5\n2 2\n255\n\x00",
        b"P5\n0 2\n255\n",
        b"P5\n999999 2\n255\n",
        b"P5\n1 1\n0\n\x00",
        b"P2\n1 1\n255\nx\n",
        b"P2\n1 1\n255\n99999999999999999999\n",
        b"P2\n1 1\n255\n-1\n",
        b"P2\n1 1\n255\n256\n",
        b"P5\n1 1\n100\n\x65",
        b"P5" + b" " * 10_000,
        b"P5\n20000 20000\n255\n",
        b"\x89PNG\r\n\x1a\n",
        encoded(np.zeros((2, 2, 1), np.uint8), 0, [0])[:-30],
        encoded(np.zeros((2, 2, 1), np.uint8), 3, [0]),
    ],
)
def test_what_is_no_picture_is_told_so(data: bytes) -> None:
    with pytest.raises(GreyImageError):
        read_grey(data)


def test_no_more_is_unpacked_than_the_picture_has() -> None:
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0))
    bomb = chunk(b"IDAT", zlib.compress(bytes(100_000_000), 9))
    tracemalloc.start()
    read_grey(b"\x89PNG\r\n\x1a\n" + header + bomb + chunk(b"IEND", b""))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1_000_000


@given(st.binary(max_size=200), st.integers(0, 80))
def test_damage_never_raises_anything_else(noise: bytes, place: int) -> None:
    whole = encoded(np.arange(12, dtype=np.uint8).reshape(2, 2, 3), 2, [4])
    try:
        read_grey(whole[:place] + noise + whole[place + len(noise) :])
    except GreyImageError as error:
        assert str(error)
