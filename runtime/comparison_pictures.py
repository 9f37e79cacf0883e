"""The maps of a comparison as pictures of one size, north up, all of the same part of the floor."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.grid import Patch
from echogrid.mapping.long_term_map import MapImage
from echogrid.mapping.metrics import Mask
from echogrid.runtime.compared_theories import WHAT_IT_IS
from echogrid.runtime.comparison import Comparison, Floats
from echogrid.runtime.map_picture import PATH, UNKNOWN, shades
from echogrid.runtime.picture_sheet import Gallery, Picture, Pixels

ECHO = (20, 20, 20)
_HEAT = np.array([(255, 255, 255), (253, 187, 99), (214, 69, 36), (96, 10, 20)], np.float64)
"""No conflict, a third of the most that is shown, two thirds, and that."""
_SHOWN = 99.0
"""Per cent of the cells with a conflict; the others are as dark as can be."""
_MARGIN = 3
_STRIDE = 1.0
"""m: between poses that are further apart the way is not drawn."""


_KEY = (
    ((255, 255, 255), "free"),
    ((0, 0, 0), "occupied"),
    ((128, 128, 128), "undecided"),
    (UNKNOWN, "unknown"),
)


def maps(comparison: Comparison) -> Gallery:
    """The maps side by side."""
    return Gallery("side by side", ("North is up.",), _KEY, tuple(_pictures(comparison)))


def _pictures(comparison: Comparison) -> Iterator[Picture]:
    """The truth, if it is known, the echoes, each theory's map, and where Dempster-Shafer finds conflict."""
    box = _box(comparison)
    if comparison.walls is not None:
        image = MapImage(comparison.geometry, comparison.walls.astype(np.float32), ~comparison.judged)
        yield _picture("truth", "what is true of the judged cells", shades(image), box)
    yield _picture(
        "echoes", "where on the axis each echo ends, and the robot's way", _echoes(comparison), box
    )
    for found in comparison.findings:
        image = MapImage(comparison.geometry, found.occupancy.astype(np.float32), found.unknown)
        yield _picture(found.name, WHAT_IT_IS[found.name], shades(image), box)
    for found in comparison.findings:
        if found.conflict is not None:
            most = _most(found.conflict)
            told = f"the weight of conflict (11.10) in each cell, white 0, darkest {most:.3g} nats and more"
            yield _picture("conflict", told, heat(found.conflict, most, found.unknown), box)


def heat(conflict: Floats, most: float, unknown: Mask) -> Pixels:
    """(rows, cols, 3) white where there is no conflict, darkest at the most; row 0 = south."""
    steps = np.linspace(0.0, most, len(_HEAT))
    channels = [np.interp(conflict, steps, _HEAT[:, channel]) for channel in range(3)]
    cells = np.rint(np.stack(channels, axis=-1)).astype(np.uint8)
    cells[unknown] = UNKNOWN
    return cells


def _picture(name: str, caption: str, cells: Pixels, box: Patch) -> Picture:
    return Picture(name, caption, cells[box][::-1])


def _box(comparison: Comparison) -> Patch:
    """The rows and columns of which anything is known."""
    known = comparison.judged | comparison.echo_ends
    for found in comparison.findings:
        known = known | ~found.unknown
    rows, cols = np.nonzero(known.any(axis=1))[0], np.nonzero(known.any(axis=0))[0]
    return _around(rows, known.shape[0]), _around(cols, known.shape[1])


def _around(cells: NDArray[np.intp], size: int) -> slice:
    return slice(max(int(cells[0]) - _MARGIN, 0), min(int(cells[-1]) + _MARGIN + 1, size))


def _echoes(comparison: Comparison) -> Pixels:
    """Echoes black, the robot's way blue, the rest as unknown."""
    cells = np.full((*comparison.geometry.shape, 3), UNKNOWN, np.uint8)
    cells[_driven(comparison)] = PATH
    cells[comparison.echo_ends] = ECHO
    return cells


def _driven(comparison: Comparison) -> Mask:
    """(rows, cols) the cells of the robot's way."""
    geometry = comparison.geometry
    mask = np.zeros(geometry.shape, np.bool_)
    for start, end in pairwise(np.array([*comparison.path, comparison.path[-1]])):
        length = float(np.hypot(*(end - start)))
        steps = int(length / geometry.resolution * 2.0) + 1 if length < _STRIDE else 1
        for step in range(steps):
            cell = geometry.cell(*(start + (end - start) * step / steps))
            if geometry.contains(*cell):
                mask[cell] = True
    return mask


def _most(conflict: Floats) -> float:
    some = conflict[conflict > 0.0]
    return float(np.percentile(some, _SHOWN)) if len(some) else 1.0
