"""The map as a person wants to see it: known area only, the driven path on top, a bar of one metre."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.long_term_map import MapImage
from echogrid.mapping.pose import Pose

UNKNOWN = (176, 184, 192)
PATH = (30, 110, 220)
_START = (20, 150, 60)
_END = (210, 40, 40)
_WIDTH_PIXELS = 1000
_MARGIN_CELLS = 4

Spot = tuple[int, int]
"""A pixel's row and column."""


def picture(image: MapImage, path: Sequence[Pose]) -> NDArray[np.uint8]:
    """(rows, cols, 3) RGB, north up: black occupied, white free, blue-grey unknown; path blue from a green to
    a red dot."""
    first_row, first_col, rows, cols = _frame(image, path)
    scale = max(1, _WIDTH_PIXELS // max(rows, cols))
    box = slice(first_row, first_row + rows), slice(first_col, first_col + cols)
    pixels = np.repeat(np.repeat(shades(image)[box], scale, axis=0), scale, axis=1)
    size = image.geometry.resolution / scale
    west = image.geometry.x + first_col * image.geometry.resolution
    south = image.geometry.y + first_row * image.geometry.resolution
    spots = [(round((pose.y - south) / size), round((pose.x - west) / size)) for pose in path]
    for start, end in pairwise(spots):
        if _shows(pixels, start) and _shows(pixels, end):
            _line(pixels, start, end)
    for spot, colour in zip(spots[:1] + spots[-1:], (_START, _END), strict=False):
        _dot(pixels, spot, 4, colour)
    _metre(pixels, round(1.0 / size))
    return pixels[::-1]


def shades(image: MapImage) -> NDArray[np.uint8]:
    """(rows, cols, 3) RGB of the cells, row 0 = south."""
    grey = np.rint(255.0 * (1.0 - image.occupancy)).astype(np.uint8)
    pixels = np.repeat(grey[:, :, np.newaxis], 3, axis=2)
    pixels[image.unknown] = UNKNOWN
    return pixels


def _frame(image: MapImage, path: Sequence[Pose]) -> tuple[int, int, int, int]:
    """First row and column, rows and columns of the part worth showing."""
    rows, cols = np.nonzero(~image.unknown)
    cells = [image.geometry.cell(pose.x, pose.y) for pose in path]
    inside = [cell for cell in cells if image.geometry.contains(*cell)]
    all_rows = np.concatenate([rows, np.array([cell[0] for cell in inside], np.intp)])
    all_cols = np.concatenate([cols, np.array([cell[1] for cell in inside], np.intp)])
    if not len(all_rows):
        return 0, 0, image.geometry.rows, image.geometry.cols
    first_row, last_row = _span(all_rows, image.geometry.rows)
    first_col, last_col = _span(all_cols, image.geometry.cols)
    return first_row, first_col, last_row - first_row + 1, last_col - first_col + 1


def _span(cells: NDArray[np.intp], size: int) -> tuple[int, int]:
    return max(int(cells.min()) - _MARGIN_CELLS, 0), min(int(cells.max()) + _MARGIN_CELLS, size - 1)


def _shows(pixels: NDArray[np.uint8], spot: Spot) -> bool:
    rows, cols, _ = pixels.shape
    return bool(0 <= spot[0] < rows and 0 <= spot[1] < cols)


def _dot(pixels: NDArray[np.uint8], spot: Spot, radius: int, colour: tuple[int, int, int]) -> None:
    row, col = spot
    if _shows(pixels, spot):
        pixels[max(row - radius, 0) : row + radius + 1, max(col - radius, 0) : col + radius + 1] = colour


def _line(pixels: NDArray[np.uint8], start: Spot, end: Spot) -> None:
    steps = max(abs(end[0] - start[0]), abs(end[1] - start[1]), 1)
    for step in range(steps + 1):
        part = step / steps
        spot = round(start[0] + part * (end[0] - start[0])), round(start[1] + part * (end[1] - start[1]))
        _dot(pixels, spot, 1, PATH)


def _metre(pixels: NDArray[np.uint8], length: int) -> None:
    pixels[6:10, 8 : 8 + length] = (0, 0, 0)
