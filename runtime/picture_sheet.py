"""Pictures with their names, together in one."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from echogrid.runtime.lettering import HEIGHT, written

Pixels = NDArray[np.uint8]
Colour = tuple[int, int, int]

GAP = 8
_SHEET = 1600
"""Pixels: the width of a sheet, about, and no more."""
_LETTERS, _TITLE = 2, 3
"""Pixels for each of a letter's."""
_INK = 40
_WHITE = 255


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture and what it shows."""

    name: str
    caption: str
    pixels: Pixels
    """(rows, cols, 3) RGB; row 0 on top."""


@dataclass(frozen=True, slots=True)
class Gallery:
    """Pictures of one size that belong together."""

    title: str
    facts: tuple[str, ...]
    key: tuple[tuple[Colour, str], ...]
    """What colours mean."""
    pictures: tuple[Picture, ...]
    abreast: int = 4


def enlarged(pixels: Pixels, scale: int) -> Pixels:
    """The same with so many pixels for each, down and across."""
    return np.repeat(np.repeat(pixels, scale, axis=0), scale, axis=1)


def sheet(shown: Sequence[Picture], abreast: int = 4) -> Pixels:
    """(rows, cols, 3) all pictures in one, each beneath its name, in their order, on white."""
    rows, cols, _ = shown[0].pixels.shape
    scale = max(1, _SHEET // (abreast * cols))
    head = _LETTERS * HEIGHT + GAP // 2
    high, wide = head + rows * scale + GAP, cols * scale + GAP
    down = -(-len(shown) // abreast)
    result = np.full((down * high - GAP, abreast * wide - GAP, 3), _WHITE, np.uint8)
    for index, picture in enumerate(shown):
        top, left = index // abreast * high, index % abreast * wide
        write(result[top : top + head, left : left + cols * scale], picture.name, _LETTERS)
        top += head
        result[top : top + rows * scale, left : left + cols * scale] = enlarged(picture.pixels, scale)
    return result


def sheets(galleries: Iterable[Gallery]) -> Pixels:
    """(rows, cols, 3) the sheets of all galleries, beneath each other, each beneath its title."""
    drawn = [(gallery.title, sheet(gallery.pictures, gallery.abreast)) for gallery in galleries]
    wide = max(pixels.shape[1] for _, pixels in drawn)
    strips = []
    for title, pixels in drawn:
        head = np.full((_TITLE * HEIGHT + 2 * GAP, wide, 3), _WHITE, np.uint8)
        write(head[GAP:], title, _TITLE)
        room = ((0, GAP), (0, wide - pixels.shape[1]), (0, 0))
        strips += [head, np.pad(pixels, room, constant_values=_WHITE)]
    return np.concatenate(strips)


def write(pixels: Pixels, words: str, scale: int) -> None:
    """Write into the upper left corner of a picture what of the words there is room for."""
    mask = written(words, scale)[: pixels.shape[0], : pixels.shape[1]]
    pixels[: mask.shape[0], : mask.shape[1]][mask] = _INK
