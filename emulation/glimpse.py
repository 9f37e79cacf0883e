"""What of a vista a ping can meet at all, by where its ranger looks: the rest need not be asked.

The floor is cut into squares and the circle into sectors. What lies surely outside of a beam, from everywhere
in the square and for every direction in the sector, is left out of lists whose order stays; so what is heard
is the same, to the bit.
"""

from collections.abc import Sequence
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
_HEADINGS = (np.arange(SECTORS) + 0.5) * tau / SECTORS
"""rad, the sectors' middles."""
_SURE = 1e-6
"""rad and m: rounding is far less."""
_ASIDE = pi / SECTORS + _SURE
"""rad: by so much a direction may differ from its sector's middle."""


class Panorama:
    """A vista from around a square of the floor, by the sectors into which an ear may look."""

    def __init__(self, vista: Vista, square: "Square", ear: Ear) -> None:
        self._vista = vista
        fan = atan(ear.fan_slope)
        beam = max(atan(ear.beam_slope), fan)
        barriers = square.seen(_ends(vista.barriers))
        self._met = (
            barriers.crossed(0.0),
            barriers.crossed(beam),
            square.faced(vista.smooth, beam, ear.reach),
            square.seen(np.array([wall.ends for wall in vista.rough]).reshape(-1, 2, 2)).beside(fan),
            square.held(vista.corners, beam, ear.reach),
            square.held(vista.edges, beam, ear.edge_reach),
            square.met(vista.posts, beam),
        )
        """(SECTORS, n) each, for each of the vista's lists."""

    def glimpse(self, sector: int) -> Vista:
        """What of it may be met within a beam: reflected, crossed by a way to what is heard, or cast upon.

        `walls` are those that the axis may meet.
        """
        vista = self._vista
        walls, barriers, smooth, rough, corners, edges, posts = (met[sector].tolist() for met in self._met)
        return Vista(
            tuple(compress(vista.walls, walls)),
            tuple(compress(vista.barriers, barriers)),
            tuple(compress(vista.smooth, smooth)),
            tuple(compress(vista.rough, rough)),
            tuple(compress(vista.corners, corners)),
            tuple(compress(vista.edges, edges)),
            tuple(compress(vista.posts, posts)),
        )


class Square(NamedTuple):
    """The circle around a square of the floor, m. Answers are by sector, (SECTORS, n)."""

    x: float
    y: float
    radius: float

    def seen(self, points: FloatArray, radius: FloatArray | float = 0.0) -> "_Seen":
        """Points (..., 2), or the discs around them."""
        dx, dy = points[..., 0] - self.x, points[..., 1] - self.y
        share = (self.radius + radius + _SURE) / np.maximum(np.hypot(dx, dy), _SURE)
        slack = np.where(share < 1.0, np.arcsin(np.minimum(share, 1.0)), tau)
        return _Seen(_off_headings(np.arctan2(dy, dx)), slack + _SURE)

    def faced(self, walls: Sequence[Wall], beam: float, reach: float) -> BoolArray:
        """Which walls may be met squarely."""
        table = np.array(walls).reshape(-1, 9)
        height = table[:, 1] * self.x + table[:, 2] * self.y - table[:, 3]
        away = np.abs(height) - self.radius
        foot = np.arctan2(-np.sign(height) * table[:, 2], -np.sign(height) * table[:, 1])
        ahead = np.abs(_off_headings(foot)) <= beam + _ASIDE
        return np.asarray((away <= _SURE) | (ahead & (away <= reach + _SURE)))

    def held(self, notches: Sequence[Notch], beam: float, reach: float) -> BoolArray:
        """Which points may lie in the beam."""
        points = np.array(notches).reshape(-1, 6)[:, :2]
        near = np.hypot(points[:, 0] - self.x, points[:, 1] - self.y) - self.radius <= reach
        return np.asarray(self.seen(points).within(beam) & near)

    def met(self, posts: Sequence[Post], beam: float) -> BoolArray:
        """Which round things may reach into it."""
        table = np.array(posts).reshape(-1, 4)
        return self.seen(table[:, :2], table[:, 2]).within(beam)


class _Seen(NamedTuple):
    """Where points lie for whoever looks from a square. Beams have their half width, rad."""

    bearing: FloatArray
    """(SECTORS, ...) rad off the heading, from the square's middle."""
    slack: FloatArray
    """(...) rad: by how much it may differ."""

    def within(self, beam: float) -> BoolArray:
        """(SECTORS, ...) which may lie in the beam."""
        return np.asarray(np.abs(self.bearing) <= self.slack + (beam + _ASIDE))

    def crossed(self, beam: float) -> BoolArray:
        """(SECTORS, n) which walls, by their two ends, may reach into the beam."""
        behind = np.abs(self.bearing) - self.slack > 0.5 * pi + _ASIDE
        return self.beside(beam) & ~behind.all(axis=-1)

    def beside(self, beam: float) -> BoolArray:
        """(SECTORS, n) which are not wholly beyond one and the same border of it; they may be behind."""
        beyond_left, beyond_right = (
            self._beyond(bearing - (beam + _ASIDE)).all(axis=-1) for bearing in (self.bearing, -self.bearing)
        )
        return np.asarray(~(beyond_left | beyond_right))

    def _beyond(self, off: FloatArray) -> BoolArray:
        """Which points surely lie in the half circle from a border on; `off` it, from -2 pi to pi."""
        return np.asarray((off > self.slack) & (off < pi - self.slack) | (off < -pi - self.slack))


def _off_headings(direction: FloatArray) -> FloatArray:
    """(SECTORS, ...) rad, -pi to pi."""
    off = direction - _HEADINGS.reshape(-1, *(1,) * direction.ndim)
    return np.asarray(off - tau * np.rint(off / tau))


def _ends(barriers: Sequence[Barrier]) -> FloatArray:
    """(n, 2, 2)."""
    table = np.array(barriers).reshape(-1, 7)
    return np.stack((table[:, 3:5], table[:, 3:5] + table[:, 5:7]), axis=1)
