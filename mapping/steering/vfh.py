"""The vector field histogram (Borenstein & Koren 1991): the nearest valley between peaks of density."""

from dataclasses import dataclass
from math import sqrt, tau

import numpy as np

from echogrid.mapping.pose import wrap_angle
from echogrid.mapping.steering.decision import Candidate, Decision, Polar, Why
from echogrid.mapping.steering.goal import Goal
from echogrid.mapping.steering.limits import bounded
from echogrid.mapping.steering.obstacles import MOST, View
from echogrid.mapping.steering.sectors import (
    Floats,
    Indices,
    Opening,
    apart,
    openings,
    ring_sum,
    to_sectors,
    totals,
)
from echogrid.mapping.steering.window import Window

_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class VfhNumbers:
    """The thresholds and widths."""

    blocking: float = 1.2
    """m: a sector is blocked by obstacles of this `area` (m^2), of full certainty, at that distance in it."""
    area: float = 0.03
    """12 cells of 5 cm: much less, and smoothing shuts doors."""
    smoothing: int = 5
    """l."""
    wide: int = 18
    """s_max, sectors."""


class Vfh:
    """Steers into the valley nearest to the goal. Sector k is what lies in k alpha...(k + 1) alpha."""

    def __init__(self, window: Window, numbers: VfhNumbers | None = None) -> None:
        self._window = window
        self._numbers = numbers or VfhNumbers()
        self._factor = factors(window.squared, window.half)
        self._sector = sectors_of(window)
        cells = self._numbers.area / window.resolution**2
        self.threshold = cells * self._one_cell() * _middle(self._numbers.smoothing)
        """tau, of the smoothed densities."""

    def steer(self, view: View, _speed: float, goal: Goal) -> Decision:
        """The middle of a narrow valley; s_max/2 inside a wide one, or the goal if it lies farther in."""
        n = self._window.sectors
        density = smoothed(self._densities(view, goal), self._numbers.smoothing)
        blocked = (density >= self.threshold) | view.shut
        polar = Polar(density, self.threshold, self.threshold, blocked, np.zeros_like(blocked))
        if view.touching or blocked.all():
            return Decision(None, 0.0, Why.TOUCHING if view.touching else Why.BLOCKED, goal, polar)
        target = to_sectors(goal.bearing, n) - 0.5
        ways = [self._way(valley, target) for valley in openings(blocked)] or [Candidate(target, 0.0)]
        ways.sort(key=lambda way: way.cost)
        chosen = ways[0].sector
        straight = apart(chosen, target, n) < _ROUNDING
        heading = goal.bearing if straight else wrap_angle((chosen + 0.5) * tau / n)
        here = int(to_sectors(view.robot.yaw, n)) % n
        open_here = 1.0 - min(float(density[here]) / self.threshold, 1.0)
        factor = open_here * float(view.known[round(chosen + 0.5) % n])
        return Decision(heading, factor, Why.TARGET if straight else Why.AROUND, goal, polar, tuple(ways))

    def forget(self) -> None:
        """It remembers nothing."""

    def _densities(self, view: View, goal: Goal) -> Floats:
        """(n,) h_k: the sum of m = C^2 (a - b d) over each sector's cells."""
        hits = view.within(goal.distance + self._window.keep)
        weights = view.certainty[hits].astype(np.float64) ** 2 * self._factor[hits]
        return totals(self._sector[hits], weights, self._window.sectors)

    def _way(self, valley: Opening, target: float) -> Candidate:
        """The way through a valley, in sectors, and how far off the goal its nearer border is."""
        n, inside = self._window.sectors, min(valley.width, self._numbers.wide) / 2.0
        middle = (valley.right + valley.left) / 2.0
        off = (target - middle + n / 2.0) % n - n / 2.0
        room = valley.width / 2.0
        return Candidate(middle + bounded(off, room - inside), max(abs(off) - room, 0.0))

    def _one_cell(self) -> float:
        """m of a cell of full certainty at the distance that blocks, at the window's border at most."""
        cells = min(self._numbers.blocking / self._window.resolution, float(self._window.half))
        return MOST**2 * float(factors(np.array([cells**2]), self._window.half)[0])


def sectors_of(window: Window) -> Indices:
    """(n,) k = floor(beta/alpha) of each cell."""
    turns = window.bearing / tau * window.sectors
    return np.floor(turns + _ROUNDING).astype(np.intp) % window.sectors


def factors(squared: Floats, half: int) -> Floats:
    """a - b d of cells at d^2 (in cells), b = 1, a = d_max = sqrt(2) (w_s - 1)/2."""
    result: Floats = sqrt(2.0) * half - np.sqrt(squared)
    return result


def smoothed(density: Floats, half: int) -> Floats:
    """h'_k = sum of w_i h_(k+i) / (2l + 1) for i in -l...l, where w_i = l + 1 - |i|.

    The printed weights are ambiguous; these add up to (l + 1)^2/(2l + 1), 36/11 for l = 5.
    """
    weights = half + 1.0 - np.abs(np.arange(-half, half + 1))
    return ring_sum(density, weights / (2 * half + 1))


def _middle(half: int) -> float:
    """What smoothing leaves of a single peak."""
    return (half + 1) / (2 * half + 1)
