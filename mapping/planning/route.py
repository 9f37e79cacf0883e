"""A way to the goal, and the point of it to head for now."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import ceil, hypot, inf

import numpy as np

from echogrid.mapping.planning.terrain import Point, Terrain, shared
from echogrid.mapping.planning.wavefront import Floats, cost_to_go, descent

_SLACK = 1.5
"""Cells: the wave reckons from middle to middle, and neither end need be in one."""


@dataclass(frozen=True, eq=False)
class Route:
    """From where the robot was when it was found to the goal."""

    points: Floats
    """(n, 2) x and y, m, in the memory's frame; n at least 2."""

    @property
    def end(self) -> Point:
        """m; the goal, or the nearest place to it where the robot can be."""
        return float(self.points[-1, 0]), float(self.points[-1, 1])

    @cached_property
    def lengths(self) -> Floats:
        """(n,) m from each point to the end."""
        steps = np.hypot(*np.diff(self.points, axis=0).T)
        return np.concatenate((np.cumsum(steps[::-1])[::-1], [0.0]))

    def after(self, here: Point) -> int:
        """The number of the point that is nearest to a place; of several the last."""
        away = np.hypot(*(self.points - here).T)
        return len(away) - 1 - int(away[::-1].argmin())

    def left(self, ground: Terrain, here: Point) -> "Route":
        """The rest of it, from a place beside it."""
        number = min(self.after(here) + 1, len(self.points) - 1)
        back = _dotted([here, self._point(number)], ground.geometry.resolution)
        return Route(np.concatenate((back, self.points[number + 1 :])))

    def carrot(self, ground: Terrain, here: Point, look_ahead: float) -> tuple[Point, float]:
        """The farthest point, up to `look_ahead` m of way from here, straight to which the way is open.

        And the length of the way from here by that point to the end, m. If none is open it is the next one.
        """
        first = min(self.after(here) + 1, len(self.points) - 1)
        last = first
        while last + 1 < len(self.points) and self.lengths[first] - self.lengths[last + 1] <= look_ahead:
            last += 1
        while last > first and not ground.is_open(here, self._point(last)):
            last -= 1
        point = self._point(last)
        return point, hypot(point[0] - here[0], point[1] - here[1]) + float(self.lengths[last])

    def ahead(self, here: Point, most: float) -> Floats:
        """(k, 2) its points from here on, for `most` m of way; at least one."""
        first = min(self.after(here) + 1, len(self.points) - 1)
        ahead: Floats = self.points[first:][self.lengths[first] - self.lengths[first:] <= most]
        return ahead

    def _point(self, number: int) -> Point:
        return self.points.item(number, 0), self.points.item(number, 1)

    def price(self, ground: Terrain) -> float:
        """m, dear stretches counted as longer; inf if it is blocked."""
        weights = ground.weights.take(ground.beneath(self.points))
        steps = self.lengths[:-1] - self.lengths[1:]
        return float((steps * 0.5 * (weights[:-1] + weights[1:])).sum())

    def is_shut(self, ground: Terrain, here: Point) -> bool:
        """Whether what is left of it from here on has become blocked."""
        return not ground.passable.take(ground.beneath(self.left(ground, here).points)).all()

    def beside(self, other: "Route", aside: float) -> bool:
        """Whether no point of it is farther than that (m) from the other one: much the same way."""
        apart = self.points[:, np.newaxis] - other.points[np.newaxis]
        return bool((np.hypot(apart[..., 0], apart[..., 1]).min(axis=1) <= aside).all())


def found(ground: Terrain, here: Point, goal: Point) -> Route | None:
    """The cheapest way; None if none leads there."""
    start, end = ground.nearest(here), ground.nearest(goal)
    if start is None or end is None:
        return None
    cost = cost_to_go(ground.weights, end, start)
    if cost[start] == inf:
        return None
    cells = descent(cost, ground.weights, start)
    end_point = goal if end == ground.geometry.cell(*goal) else ground.middle(end)
    way = [here, *(ground.middle(cell) for cell in cells[1:-1]), end_point]
    left = [float(cost[cell]) * ground.geometry.resolution for cell in cells]
    return Route(_dotted(_tight(ground, way, [*left, 0.0][: len(way)]), ground.geometry.resolution))


def _tight(ground: Terrain, way: list[Point], left: list[float]) -> list[Point]:
    """The way cut short wherever a straight line is open and no dearer; `left`: its price from each point."""
    kept, first = [way[0]], 0
    while first < len(way) - 1:
        first = _farthest(ground, way, left, first)
        kept.append(way[first])
    return kept


def _farthest(ground: Terrain, way: list[Point], left: list[float], first: int) -> int:
    """The number of the point up to which it can be cut short from `first` on: by doubling, then halving."""
    last, step, grows = first + 1, 1, True
    while step:
        there = last + step
        good = there < len(way) and _is_as_good(ground, (way[first], way[there]), left[first] - left[there])
        last = there if good else last
        grows = grows and good
        step = 2 * step if grows else step // 2
    return last


def _is_as_good(ground: Terrain, line: tuple[Point, Point], price: float) -> bool:
    return ground.is_open(*line) and ground.price(*line) <= price + _SLACK * ground.geometry.resolution


def _dotted(corners: list[Point], apart: float) -> Floats:
    """(n, 2) points from corner to corner, at most so far (m) from each other."""
    parts = [np.array([corners[0]])]
    for here, there in pairwise(corners):
        count = max(ceil(hypot(there[0] - here[0], there[1] - here[1]) / apart), 1)
        shares = shared(count)[1:, np.newaxis]
        parts.append((1.0 - shares) * here + shares * there)
    return np.concatenate(parts)
