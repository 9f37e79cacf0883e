"""What a robot remembers of its surroundings after its local grid has moved on or faded."""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, cos, floor, hypot, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.planning.floor_plan import FloorPlan
from echogrid.mapping.pose import ORIGIN, Pose

_MOST = 100
"""Times that are counted."""
_BLOCK = 32
"""Cells by which it grows, so that it need not each time."""


@dataclass(frozen=True, slots=True)
class Remembering:
    """What is kept of a local grid."""

    obstacle: int = 850
    """Milli-nats from which a cell of the local grid is an obstacle: the virtual sensor's limit."""
    free: int = -400
    """Milli-nats up to which it is free."""
    reach: float = 2.0
    """m from the robot: what lies beyond is not taken over, as echoes that came by way of walls seem far."""
    lately_ns: int = 1_000_000_000
    """For how long after it was last spoken of a free cell can take an obstacle from the memory."""
    sighting: int = 3
    """For each time that an obstacle is seen there it must be seen free so many times to be forgotten, as
    sound that strikes a wall aslant goes astray, and tells of free space behind it ..."""
    firmness: int = 60
    """... but no more times than that in all."""
    patience: int = 1
    """An obstacle must have been there so many times in a row to be remembered: who knows the walls need not
    believe in all that passes by."""

    def __post_init__(self) -> None:
        if not (self.free < 0 < self.obstacle and 1 <= self.sighting <= self.firmness <= 63):
            raise ValueError("free must lie below 0, obstacle above it, and 1 <= sighting <= firmness <= 63")
        if not 1 <= self.patience <= _MOST:
            raise ValueError(f"patience must lie in 1...{_MOST}")


class Recollection:
    """A grid that grows with what is seen, in the odom frame; in the plan's for who studied one.

    `belief` (rows, cols) int8, row 0 = south: above 0 an obstacle, the higher the more often it was seen;
    0 unknown; -1 free.
    """

    def __init__(self, resolution: float = 0.1, remembering: Remembering | None = None) -> None:
        self._resolution = resolution
        self._remembering = remembering or Remembering()
        self._corner = (0, 0)
        """Row and column of the first cell, counted from the origin of the frame."""
        self.belief: NDArray[np.int8] = np.zeros((_BLOCK, _BLOCK), np.int8)
        self._held: NDArray[np.bool_] = np.zeros((_BLOCK, _BLOCK), np.bool_)
        self._lasting: NDArray[np.int8] = np.zeros((_BLOCK, _BLOCK), np.int8)
        """How many times in a row an obstacle has been there."""
        self._built: NDArray[np.bool_] = np.zeros((_BLOCK, _BLOCK), np.bool_)
        """Where walls stand by a plan: these stay."""
        self._beside: NDArray[np.bool_] = np.zeros((_BLOCK, _BLOCK), np.bool_)
        """These, and all around them: the local grid shows them a cell wider."""

    @property
    def geometry(self) -> GridGeometry:
        """Where it is."""
        (row, col), step = self._corner, self._resolution
        return GridGeometry(step, col * step, row * step, *self.belief.shape)

    def cover(self, x: float, y: float, around: float) -> None:
        """Grow, if need be, so that it reaches so far (m) around a point; new cells are unknown."""
        ends = ((y - around, y + around), (x - around, x + around))
        pads = [self._padding(axis, low, high) for axis, (low, high) in enumerate(ends)]
        if any(pad != (0, 0) for pad in pads):
            self.belief, self._held = np.pad(self.belief, pads), np.pad(self._held, pads)
            self._built, self._lasting = np.pad(self._built, pads), np.pad(self._lasting, pads)
            self._beside = np.pad(self._beside, pads)
            self._corner = (self._corner[0] - pads[0][0], self._corner[1] - pads[1][0])

    def _padding(self, axis: int, low: float, high: float) -> tuple[int, int]:
        first, size = self._corner[axis], self.belief.shape[axis]
        before = first - floor(low / self._resolution)
        after = ceil(high / self._resolution) - first - size
        return _blocks(before), _blocks(after)

    def study(self, plan: FloorPlan) -> None:
        """Take over a plan, in whose frame the memory then is; its walls are not forgotten."""
        points = np.concatenate((plan.free, plan.walls))
        if not len(points):
            return
        for x, y in (points.min(axis=0), points.max(axis=0)):
            self.cover(float(x), float(y), 2.0 * self._resolution)
        self.belief.ravel()[self._beneath(plan.free)] = -1
        self._built.ravel()[self._beneath(plan.walls)] = True
        self.belief[self._built] = self._remembering.firmness
        self._beside = _widened(self._built)

    def take(self, local: LocalGrid, now_ns: int, frame: Pose = ORIGIN) -> None:
        """Take over what the local grid, in whose middle the robot is, holds now.

        `frame` is the pose of the local grid's frame in that of the memory.
        """
        geometry, log_odds = local.geometry, local.grid.log_odds
        half = 0.5 * geometry.resolution * geometry.rows
        middle = frame.compose(Pose(geometry.x + half, geometry.y + half))
        self.cover(middle.x, middle.y, sqrt(2.0) * half + self._resolution)
        keep = self._remembering
        log_odds = np.where(_near(geometry.rows, geometry.resolution, keep.reach), log_odds, np.int16(0))
        lately = (local.seen_ns > 0) & (local.seen_ns >= now_ns - keep.lately_ns)
        places = self._places(geometry, frame)
        obstacle = self._holding(places[log_odds >= keep.obstacle])
        doubted = self._holding(places[log_odds > 0])
        free = self._holding(places[(log_odds <= keep.free) & lately]) & ~doubted
        wholly = ~self._holding(places[log_odds > keep.free])
        self._learn(obstacle & ~self._beside, free, wholly)

    def _learn(self, obstacle: NDArray[np.bool_], free: NDArray[np.bool_], wholly: NDArray[np.bool_]) -> None:
        belief, keep = self.belief, self._remembering
        remembered = belief > 0
        self._lasting = np.where(obstacle, np.minimum(self._lasting, _MOST - 1) + 1, 0).astype(np.int8)
        obstacle &= self._lasting >= keep.patience
        belief[obstacle] = np.minimum(np.maximum(belief[obstacle], 0) + keep.sighting, keep.firmness)
        worn = free & wholly & remembered & ~self._built
        belief[worn] -= 1
        belief[free & (belief == 0)] = -1
        self._held = obstacle

    def _places(self, geometry: GridGeometry, frame: Pose) -> NDArray[np.intp]:
        """(rows, cols) of a local grid: the cell here, row * columns + column, of each one's middle."""
        c, s = cos(frame.yaw), sin(frame.yaw)
        x, y = geometry.x_centres, geometry.y_centres[:, np.newaxis]
        return self._cells(frame.x + c * x - s * y, frame.y + s * x + c * y)

    def _beneath(self, points: NDArray[np.float64]) -> NDArray[np.intp]:
        """(n,) the cells under points (n, 2)."""
        return self._cells(points[:, 0], points[:, 1])

    def _cells(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.intp]:
        """row * columns + column."""
        down = np.floor(y / self._resolution).astype(np.intp) - self._corner[0]
        right = np.floor(x / self._resolution).astype(np.intp) - self._corner[1]
        cells: NDArray[np.intp] = down * self.belief.shape[1] + right
        return cells

    def _holding(self, places: NDArray[np.intp]) -> NDArray[np.bool_]:
        """(rows, cols) which cells are among these places."""
        holding = np.zeros(self.belief.shape, np.bool_)
        holding.ravel()[places] = True
        return holding

    def tread(self, x: float, y: float, radius: float) -> None:
        """The robot stands here: no cell whose middle is within its radius (m) is an obstacle."""
        self.cover(x, y, radius + self._resolution)
        geometry = self.geometry
        row, col = geometry.cell(x, y)
        reach = ceil(radius / self._resolution) + 1
        x_centres, y_centres = geometry.x_centres.tolist(), geometry.y_centres.tolist()
        for r in range(max(row - reach, 0), min(row + reach + 1, geometry.rows)):
            for c in range(max(col - reach, 0), min(col + reach + 1, geometry.cols)):
                if hypot(x_centres[c] - x, y_centres[r] - y) <= radius and not self._built[r, c]:
                    self.belief[r, c] = -1

    def relent(self) -> None:
        """Forget the obstacles that are remembered only: that the local grid did not hold when last taken."""
        self.belief[(self.belief > 0) & ~self._held & ~self._built] = 0


def _widened(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(rows, cols) a mask, that is nowhere at its array's border, and the eight neighbours of its cells."""
    tall = mask | np.roll(mask, 1, axis=0) | np.roll(mask, -1, axis=0)
    wide: NDArray[np.bool_] = tall | np.roll(tall, 1, axis=1) | np.roll(tall, -1, axis=1)
    return wide


@lru_cache(maxsize=8)
def _near(cells: int, resolution: float, reach: float) -> NDArray[np.bool_]:
    """(cells, cols) of a local grid: which are within that reach (m) of its middle."""
    steps = np.arange(cells) - cells // 2
    near: NDArray[np.bool_] = np.hypot(steps[:, np.newaxis], steps) * resolution <= reach
    return near


def _blocks(missing: int) -> int:
    """Cells to add, in whole blocks."""
    return max(ceil(missing / _BLOCK), 0) * _BLOCK
