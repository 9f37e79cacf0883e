"""What of a vista a ping can meet at all, by where its ranger looks: the rest need not be asked.

The floor is cut into squares and the circle into sectors. What lies surely outside of a beam, from everywhere
in the square and for every direction in the sector, is left out of lists whose order stays; so what is heard
is the same, to the bit.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress
from math import atan, pi, tau
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.ear import Ear
from echogrid.emulation.vista import Barrier, Notch, Post, Vista, Wall

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

SECTORS = 48
_SURE = 1e-6
"""rad and m: rounding is far less."""


class View(NamedTuple):
    """A square of the floor, the circle around it, and a sector of directions."""

    x: float
    y: float
    """m, the middle."""
    radius: float
    """m."""
    sector: int

    @property
    def heading(self) -> float:
        """rad, the sector's middle."""
        return (self.sector + 0.5) * tau / SECTORS


def glimpse(vista: Vista, view: View, ear: Ear) -> Vista:
    """What of a vista may be met within a beam: reflected, crossed by a way to what is heard, or cast upon.

    `walls` are those that the axis may meet.
    """
    wedge = _Wedge.of(view, max(atan(ear.beam_slope), atan(ear.fan_slope)))
    axis, fan = _Wedge.of(view, 0.0), _Wedge.of(view, atan(ear.fan_slope))
    return Vista(
        tuple(compress(vista.walls, axis.crossed(_ends(vista.barriers)))),
        tuple(compress(vista.barriers, wedge.crossed(_ends(vista.barriers)))),
        tuple(compress(vista.smooth, wedge.faced(vista.smooth, ear.reach))),
        tuple(compress(vista.rough, fan.beside([wall.ends for wall in vista.rough]))),
        tuple(compress(vista.corners, wedge.holds(vista.corners, ear.reach))),
        tuple(compress(vista.edges, wedge.holds(vista.edges, ear.edge_reach))),
        tuple(compress(vista.posts, wedge.meets(vista.posts))),
    )


@dataclass(frozen=True, slots=True)
class _Wedge:
    """All that beams of one kind may cover in a view."""

    view: View
    half: float
    """rad: to either side of the heading, from each place."""

    @classmethod
    def of(cls, view: View, beam: float) -> "_Wedge":
        return cls(view, beam + pi / SECTORS + _SURE)

    def crossed(self, ends: FloatArray) -> BoolArray:
        """(n,) which walls, with their ends (n, 2, 2), may reach into it."""
        bearing, slack = self._seen(ends)
        behind = np.abs(bearing) - slack > 0.5 * pi + pi / SECTORS + _SURE
        return np.asarray(~(self._aside(bearing, slack) | behind.all(axis=1)))

    def beside(self, ends: Sequence[tuple[tuple[float, float], tuple[float, float]]]) -> BoolArray:
        """(n,) which walls are not wholly to one side of it; they may be behind."""
        if not ends:
            return np.empty(0, np.bool_)
        return np.asarray(~self._aside(*self._seen(np.array(ends))))

    def faced(self, walls: Sequence[Wall], reach: float) -> BoolArray:
        """(n,) which walls may be met squarely."""
        table = np.array(walls).reshape(-1, 9)
        height = table[:, 1] * self.view.x + table[:, 2] * self.view.y - table[:, 3]
        away = np.abs(height) - self.view.radius
        foot = np.arctan2(-np.sign(height) * table[:, 2], -np.sign(height) * table[:, 1])
        ahead = np.abs(self._turned(foot)) <= self.half
        return np.asarray((away <= _SURE) | (ahead & (away <= reach + _SURE)))

    def holds(self, notches: Sequence[Notch], reach: float) -> BoolArray:
        """(n,) which points may lie in it."""
        points = np.array(notches).reshape(-1, 6)[:, :2]
        bearing, slack = self._seen(points)
        near = np.hypot(points[:, 0] - self.view.x, points[:, 1] - self.view.y) - self.view.radius <= reach
        return np.asarray((np.abs(bearing) <= self.half + slack) & near)

    def meets(self, posts: Sequence[Post]) -> BoolArray:
        """(n,) which round things may reach into it."""
        table = np.array(posts).reshape(-1, 4)
        bearing, slack = self._seen(table[:, :2], table[:, 2])
        return np.asarray(np.abs(bearing) <= self.half + slack)

    def _seen(self, points: FloatArray, radius: FloatArray | float = 0.0) -> tuple[FloatArray, FloatArray]:
        """Bearing of points (..., 2) off the heading, from the middle, rad; by how much it may differ."""
        dx, dy = points[..., 0] - self.view.x, points[..., 1] - self.view.y
        share = (self.view.radius + radius + _SURE) / np.maximum(np.hypot(dx, dy), _SURE)
        slack = np.where(share < 1.0, np.arcsin(np.minimum(share, 1.0)), tau)
        return self._turned(np.arctan2(dy, dx)), slack + _SURE

    def _turned(self, direction: FloatArray) -> FloatArray:
        """Off the heading, -pi to pi."""
        return np.asarray((direction - self.view.heading + pi) % tau - pi)

    def _aside(self, bearing: FloatArray, slack: FloatArray) -> BoolArray:
        """(n,) whether both ends surely lie beyond one and the same border of it."""
        left, right = (bearing - self.half) % tau, (-bearing - self.half) % tau
        beyond_left = ((left > slack) & (left < pi - slack)).all(axis=1)
        beyond_right = ((right > slack) & (right < pi - slack)).all(axis=1)
        return np.asarray(beyond_left | beyond_right)


def _ends(barriers: Sequence[Barrier]) -> FloatArray:
    """(n, 2, 2)."""
    table = np.array(barriers).reshape(-1, 7)
    return np.stack((table[:, 3:5], table[:, 3:5] + table[:, 5:7]), axis=1)
