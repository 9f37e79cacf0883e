"""Walls of buildings whose rooms and furniture are upright rectangles."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int8]
Rectangle = tuple[float, float, float, float]
"""x0, y0, x1, y1 in m, with x0 < x1 and y0 < y1."""
Cushion = tuple[float, float, float, float, float]
"""A rectangle, and the softness, dB, of the surfaces in it."""


class Outline(NamedTuple):
    """The walls of a plan, as long as they go straight and are of one make."""

    walls: FloatArray
    """(n, 4): x0, y0, x1, y1, m."""
    rough: NDArray[np.bool_]
    """(n,)."""
    softness: FloatArray
    """(n,) dB."""


@dataclass(frozen=True, slots=True)
class FloorPlan:
    """Open floor (rooms, corridors, doorways), solid furniture, and where surfaces are rough or soft."""

    floors: Sequence[Rectangle]
    furniture: Sequence[Rectangle]
    rough: Sequence[Rectangle] = ()
    soft: Sequence[Cushion] = ()

    def outline(self) -> Outline:
        """Its walls."""
        cushions = [cushion[:4] for cushion in self.soft]
        rectangles = np.array([*self.floors, *self.furniture, *self.rough, *cushions])
        xs, ys = np.unique(rectangles[:, [0, 2]]), np.unique(rectangles[:, [1, 3]])
        x_middles, y_middles = 0.5 * (xs[1:] + xs[:-1]), 0.5 * (ys[1:] + ys[:-1])
        open_cells = np.zeros((len(ys) + 1, len(xs) + 1), dtype=np.bool_)
        open_cells[1:-1, 1:-1] = _covered(self.floors, x_middles, y_middles)
        open_cells[1:-1, 1:-1] &= ~_covered(self.furniture, x_middles, y_middles)
        inside = open_cells.astype(np.int8)
        level = (inside[1:] - inside[:-1])[:, 1:-1]
        upright = (inside[:, 1:] - inside[:, :-1])[1:-1].T
        level_make, upright_make = self._make(x_middles, ys), self._make(xs, y_middles).swapaxes(0, 1)
        rows = [(a, y, b, y, *make) for y, a, b, make in _runs(ys, xs, level, level_make)]
        rows += [(x, a, x, b, *make) for x, a, b, make in _runs(xs, ys, upright, upright_make)]
        table = np.array(rows)
        return Outline(table[:, :4].copy(), table[:, 4] > 0.5, table[:, 5].copy())

    def _make(self, xs: FloatArray, ys: FloatArray) -> FloatArray:
        """(len(ys), len(xs), 2): whether surfaces are rough at the points of the lattice; how soft, dB."""
        softness = np.zeros((len(ys), len(xs)))
        for x0, y0, x1, y1, taken in self.soft:
            softness[_covered([(x0, y0, x1, y1)], xs, ys)] = taken
        return np.stack((_covered(self.rough, xs, ys).astype(np.float64), softness), axis=-1)


def _covered(rectangles: Iterable[Rectangle], xs: FloatArray, ys: FloatArray) -> NDArray[np.bool_]:
    """(len(ys), len(xs)): which points of the lattice lie in one of the rectangles, or on its rim."""
    covered = np.zeros((len(ys), len(xs)), dtype=np.bool_)
    for x0, y0, x1, y1 in rectangles:
        covered |= ((ys >= y0) & (ys <= y1))[:, np.newaxis] & ((xs >= x0) & (xs <= x1))
    return covered


def _runs(
    lines: FloatArray, stops: FloatArray, steps: IntArray, makes: FloatArray
) -> Iterator[tuple[float, float, float, tuple[float, float]]]:
    """Line, start, end and make of every stretch along which floor and solid change sides."""
    for line, sides, along in zip(lines, steps, makes, strict=True):
        cells = zip(range(len(sides)), sides, along.tolist(), strict=True)
        for (side, make), run in groupby(cells, key=lambda cell: (cell[1], tuple(cell[2]))):
            indices = [cell[0] for cell in run]
            if side:
                yield float(line), float(stops[indices[0]]), float(stops[indices[-1] + 1]), make
