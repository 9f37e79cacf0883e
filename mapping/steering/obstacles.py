"""What a local grid says to a robot that must not hit anything: certainties, and what is not known."""

from dataclasses import dataclass
from math import cos, inf, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.steering.sectors import Floats, Indices, Mask, ring_sum
from echogrid.mapping.steering.window import Window
from echogrid.mapping.unknown import Unknown

MOST = 15
"""The highest certainty, as in HIMM."""
_SURE = 2000
"""Milli-nats at which the local grid's log-odds are clamped: the highest certainty."""
_CERTAINTY = (np.arange(_SURE + 1) * MOST // _SURE).astype(np.int16)


@dataclass(frozen=True, slots=True)
class Belief:
    """How a local grid is read."""

    unknown: Unknown = Unknown.SLOW
    least: int = 6
    """The certainty from which a cell is an obstacle: 0.8 nats, about where the virtual sensor sees one."""
    known: float = 0.3
    """The part of a direction's cells that must have been spoken of, and lately, for it to be known: as the
    virtual sensor's, and below what rangers see that leave gaps between them."""
    stale_ns: int = 1_000_000_000
    neighbours: int = 2
    """Sectors on both sides which are looked at with one, as the robot is wider than a sector."""

    def __post_init__(self) -> None:
        if not (1 <= self.least <= MOST and 0.0 < self.known <= 1.0):
            raise ValueError("an obstacle's least certainty must lie in 1...15, the known part in 0...1")


@dataclass(frozen=True, slots=True)
class View:
    """The window around the robot at one moment. Its arrays are its own."""

    window: Window
    robot: Pose
    """In the grid's frame."""
    log_odds: NDArray[np.int16]
    """(n,) milli-nats, of the window's cells."""
    seen_ns: NDArray[np.int64]
    """(n,) 0 if never."""
    certainty: NDArray[np.int16]
    """(n,) CV, 0...15."""
    hits: Indices
    """(h,) which of the n cells are obstacles, nearest first."""
    known: Floats
    """(sectors,) how well each direction is known, 0...1."""
    shut: Mask
    """(sectors,) directions that are closed because too little is known of them."""
    offset: tuple[float, float]
    """m: where in its cell the robot is, from the middle."""
    touching: bool
    """Whether an obstacle's middle is within the robot, or in its own cell."""

    def within(self, distance: float) -> Indices:
        """The obstacles no farther than that (m), nearest first."""
        if distance >= self.window.horizon:
            return self.hits
        return self.hits[: self.hits.searchsorted(self.window.within(distance))]

    def clearance(self, heading: float) -> float:
        """m that the robot's disc can go straight there before it touches; what the window shows at most."""
        along, across = self._turned(self.hits, heading)
        squared = self.window.body.radius**2 - across**2
        (met,) = ((squared > 0.0) & (along > 0.0)).nonzero()
        ways = along.take(met) - np.sqrt(squared.take(met))
        return min(max(float(ways.min(initial=inf)), 0.0), self.window.horizon)

    def fits(self, points: Floats, margin: float) -> Mask:
        """(k,) whether the robot's disc, and a margin (m), can go straight to each of the points (k, 2)."""
        x, y = self.window.x.take(self.hits) - self.offset[0], self.window.y.take(self.hits) - self.offset[1]
        ahead = points - (self.robot.x, self.robot.y)
        length = np.maximum(np.hypot(ahead[:, 0], ahead[:, 1]), 1e-9)[:, np.newaxis]
        c, s = ahead[:, :1] / length, ahead[:, 1:] / length
        along, across = c * x + s * y, c * y - s * x
        beyond = np.maximum(along - length, 0.0)
        keep = self.window.body.radius + margin + self.window.resolution / sqrt(2.0)
        hit = (along > 0.0) & (beyond**2 + across**2 < keep**2)
        return np.logical_not(hit.any(axis=1))

    def free(self, heading: float, distance: float) -> bool:
        """Whether all that the robot's disc comes to newly on a way (m) straight there was seen free."""
        body = self.window.body
        count = self.window.within(body.radius + distance + 2.0 * self.window.resolution)
        along, across = self._turned(slice(0, count), heading)
        beyond = np.maximum(along - distance, 0.0)
        swept = (along > 0.0) & (np.hypot(beyond, across) <= body.radius + self.window.resolution)
        new = np.hypot(along, across) > body.radius
        seen_free = (self.seen_ns[:count] > 0) & (self.log_odds[:count] < 0)
        return distance + body.radius <= self.window.horizon and bool(np.all(seen_free[swept & new]))

    def _turned(self, cells: Indices | slice, heading: float) -> tuple[Floats, Floats]:
        """How far these cells are along that heading from the robot, and beside it."""
        x, y = self.window.x[cells] - self.offset[0], self.window.y[cells] - self.offset[1]
        c, s = cos(heading), sin(heading)
        return x * c + y * s, y * c - x * s


class Obstacles:
    """Reads local grids of one size."""

    def __init__(self, window: Window, belief: Belief | None = None) -> None:
        self.window = window
        self._belief = belief or Belief()
        self._weights = np.ones(2 * self._belief.neighbours + 1)
        self._outside = window.within(window.body.radius)
        """The cells before this one are beneath the robot, of which no ping speaks."""
        self._sector = window.nearest_sector[self._outside :]
        cells = np.bincount(self._sector, minlength=window.sectors).astype(np.float64)
        self._enough = np.maximum(ring_sum(cells, self._weights) * self._belief.known, 1.0)
        """(sectors,) how many known cells make a direction known."""
        self._touchable = window.within(window.body.radius + window.resolution)

    def view(self, local: LocalGrid, robot: Pose, now_ns: int) -> View:
        """What is around the robot, in the middle of whose grid it must be (LocalGrid.centre)."""
        log_odds = local.grid.log_odds.take(self.window.flat)
        seen_ns = local.seen_ns.take(self.window.flat)
        certainty = certainties(log_odds)
        hits = np.flatnonzero(certainty >= self._belief.least)
        known = self._known(seen_ns, now_ns)
        offset = self._offset(local, robot)
        return View(
            self.window,
            robot,
            log_odds,
            seen_ns,
            certainty,
            hits,
            known,
            self._shut(known),
            offset,
            self._touches(hits, offset),
        )

    def _known(self, seen_ns: NDArray[np.int64], now_ns: int) -> Floats:
        if self._belief.unknown is Unknown.CLEAR:
            return np.ones(self.window.sectors)
        recent = seen_ns[self._outside :] > max(now_ns - self._belief.stale_ns, 0)
        cells = np.bincount(self._sector, recent, self.window.sectors).astype(np.float64, copy=False)
        return np.minimum(ring_sum(cells, self._weights) / self._enough, 1.0)

    def _shut(self, known: Floats) -> Mask:
        if self._belief.unknown is Unknown.BLOCKED:
            return known < 1.0
        return np.zeros(self.window.sectors, np.bool_)

    def _offset(self, local: LocalGrid, robot: Pose) -> tuple[float, float]:
        geometry = local.geometry
        row, col = geometry.rows // 2, geometry.cols // 2
        x = geometry.x + (col + 0.5) * geometry.resolution
        y = geometry.y + (row + 0.5) * geometry.resolution
        return robot.x - x, robot.y - y

    def _touches(self, hits: Indices, offset: tuple[float, float]) -> bool:
        near = hits[: hits.searchsorted(self._touchable)]
        if not len(near):
            return False
        away = np.hypot(self.window.x[near] - offset[0], self.window.y[near] - offset[1])
        return bool(near[0] == 0 or away.min() < self.window.body.radius)


def certainties(log_odds: NDArray[np.int16]) -> NDArray[np.int16]:
    """CV = floor(15 L / 2 nats), within 0...15: linear in the evidence for an obstacle, 0 for any against."""
    return _CERTAINTY.take(np.minimum(np.maximum(log_odds, 0), _SURE))
