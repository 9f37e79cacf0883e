"""HIMM, histogrammic in-motion mapping: counts on the axis alone, made while the robot moves.

Borenstein & Koren 1991; Murphy, Introduction to AI Robotics, 11.5. An echo adds 3 to the cell in which it
ends, and takes 1 from each cell before that (11.11). So occupied is believed three times as fast as empty,
and where the beam is wide the robot's own motion must sweep the axes over it.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.pose import Pose
from echogrid.mapping.ray import Ray, cross
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.sounding import Sounding


@dataclass(frozen=True, slots=True)
class Steps:
    """What a ping does to a count, which is a byte."""

    up: int = 3
    """I+: what an echo adds to its cell."""
    down: int = 1
    """I-: what it takes from those before it."""
    most: int = 15
    """A count stays in 0...15."""


USUAL = Steps()


class HimmGrid:
    """Counts in bytes. A cell that no axis has met is unknown, which is not the same as a count of 0.

    Silence is ignored, for there is no evidence weaker than a whole count; with `CLEAR` it takes 1 from every
    cell up to the ranger's reach. A ranger's own word on silence goes before the grid's.
    """

    def __init__(
        self,
        geometry: GridGeometry,
        no_echo: NoEcho = NoEcho.IGNORE,
        growth: bool = False,
        steps: Steps = USUAL,
    ) -> None:
        """`growth`: with the growth rate operator: an echo adds half of what the cell's eight neighbours
        have, too (after what the ping took), rounded down. So cells that stand together grow faster.
        """
        self.geometry = geometry
        self.counts: NDArray[np.uint8] = np.zeros(geometry.shape, np.uint8)
        """(rows, cols), row 0 = south."""
        self._seen: NDArray[np.bool_] = np.zeros(geometry.shape, np.bool_)
        self._clears = no_echo is NoEcho.CLEAR
        self._growth = growth
        self._steps = steps

    def update(self, sounding: Sounding) -> Patch | None:
        """Fuse one ping; the patch that it touched, None if it said nothing."""
        own = sounding.ranger.no_echo
        clears = self._clears if own is None else own is NoEcho.CLEAR
        if sounding.echo is None and not clears:
            return None
        length = sounding.ranger.farthest if sounding.echo is None else sounding.echo
        ray = cross(self.geometry, sounding.transducer, length)
        end = sounding.transducer.compose(Pose(length))
        met = self.geometry.cell(end.x, end.y) if sounding.echo is not None else None
        return self._count(ray, met)

    def _count(self, ray: Ray, met: tuple[int, int] | None) -> Patch | None:
        """Take from the cells before the echo, and add to the one in which it ends, if there is one."""
        passed = np.ones(len(ray.rows), np.bool_)
        if met is not None:
            passed = (ray.rows != met[0]) | (ray.cols != met[1])
        before = ray.rows[passed], ray.cols[passed]
        counts = self.counts[before]
        self.counts[before] = np.where(counts > self._steps.down, counts - self._steps.down, 0)
        self._seen[before] = True
        touched = ray
        if met is not None and self.geometry.contains(*met):
            self.counts[met] = min(self._risen(*met), self._steps.most)
            self._seen[met] = True
            touched = Ray(np.append(ray.rows, met[0]), np.append(ray.cols, met[1]))
        return touched.patch if len(touched.rows) else None

    def _risen(self, row: int, col: int) -> int:
        """What the cell of an echo comes to, before the clamp."""
        risen = int(self.counts[row, col]) + self._steps.up
        if not self._growth:
            return risen
        around = self.counts[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2]
        neighbours = int(around.sum(dtype=np.int64)) - int(self.counts[row, col])
        return risen + neighbours // 2

    def occupancy(self) -> NDArray[np.float32]:
        """(rows, cols) C/15, row 0 = south; 0.5 where unknown.

        It stands in for a probability, and is none: it says how often a cell was met of late, and with clamps
        as near as 0 and 15 that depends on the robot's speed and on the ranger's rate. 1 is not certain.
        """
        return np.where(self._seen, self.counts / np.float32(self._steps.most), np.float32(0.5)).astype(
            np.float32
        )

    def unknown(self) -> NDArray[np.bool_]:
        """(rows, cols) True where no axis has been."""
        return ~self._seen

    def copy(self) -> Self:
        """An independent twin."""
        no_echo = NoEcho.CLEAR if self._clears else NoEcho.IGNORE
        twin = type(self)(self.geometry, no_echo, self._growth, self._steps)
        twin.counts, twin._seen = self.counts.copy(), self._seen.copy()
        return twin
