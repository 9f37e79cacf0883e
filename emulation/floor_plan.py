"""Walls of buildings whose rooms and furniture are upright rectangles."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int8]
Rectangle = tuple[float, float, float, float]
"""x0, y0, x1, y1 in m, with x0 < x1 and y0 < y1."""


@dataclass(frozen=True, slots=True)
class FloorPlan:
    """Open floor (rooms, corridors, doorways), solid furniture on it, and where surfaces are rough."""

    floors: Sequence[Rectangle]
    furniture: Sequence[Rectangle]
    rough: Sequence[Rectangle]

    def outline(self) -> tuple[FloatArray, NDArray[np.bool_]]:
        """The walls (n, 4), as long as they go straight, and which of them are rough (n,)."""
        rectangles = np.array([*self.floors, *self.furniture, *self.rough])
        xs, ys = np.unique(rectangles[:, [0, 2]]), np.unique(rectangles[:, [1, 3]])
        x_middles, y_middles = 0.5 * (xs[1:] + xs[:-1]), 0.5 * (ys[1:] + ys[:-1])
        open_cells = np.zeros((len(ys) + 1, len(xs) + 1), dtype=np.bool_)
        open_cells[1:-1, 1:-1] = _covered(self.floors, x_middles, y_middles)
        open_cells[1:-1, 1:-1] &= ~_covered(self.furniture, x_middles, y_middles)
        inside = open_cells.astype(np.int8)
        level = (inside[1:] - inside[:-1])[:, 1:-1]
        upright = (inside[:, 1:] - inside[:, :-1])[1:-1].T
        level_rough = _covered(self.rough, x_middles, ys)
        upright_rough = _covered(self.rough, xs, y_middles).T
        rows = [(a, y, b, y, r) for y, a, b, r in _runs(ys, xs, level, level_rough)]
        rows += [(x, a, x, b, r) for x, a, b, r in _runs(xs, ys, upright, upright_rough)]
        table = np.array(rows)
        return table[:, :4].copy(), table[:, 4] > 0.5


def _covered(rectangles: Iterable[Rectangle], xs: FloatArray, ys: FloatArray) -> NDArray[np.bool_]:
    """(len(ys), len(xs)): which points of the lattice lie in one of the rectangles, or on its rim."""
    covered = np.zeros((len(ys), len(xs)), dtype=np.bool_)
    for x0, y0, x1, y1 in rectangles:
        covered |= ((ys >= y0) & (ys <= y1))[:, np.newaxis] & ((xs >= x0) & (xs <= x1))
    return covered


def _runs(
    lines: FloatArray, stops: FloatArray, steps: IntArray, rough: NDArray[np.bool_]
) -> Iterator[tuple[float, float, float, bool]]:
    """Line, start, end and roughness of every stretch along which floor and solid change sides."""
    for line, sides, scatters in zip(lines, steps, rough, strict=True):
        cells = zip(range(len(sides)), sides, scatters, strict=True)
        for (side, scatter), run in groupby(cells, key=lambda cell: (cell[1], cell[2])):
            indices = [cell[0] for cell in run]
            if side:
                yield float(line), float(stops[indices[0]]), float(stops[indices[-1] + 1]), bool(scatter)
