"""The virtual force field (Borenstein & Koren 1989): obstacles push, the goal pulls."""

from dataclasses import dataclass
from math import atan2, cos, inf, sin

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.steering.decision import Decision, Polar, Why
from echogrid.mapping.steering.goal import Goal
from echogrid.mapping.steering.obstacles import View
from echogrid.mapping.steering.sectors import Floats, to_sectors, totals

_NOTHING = 1e-12
"""A force below this has no direction."""


@dataclass(frozen=True, slots=True)
class VffForces:
    """The constants."""

    repulsion: float = 2.5e-4
    """F_cr W^n, of one cell with certainty 1 at 1 m. A wall of cells of 5 cm holds out against the goal at
    half a metre; for other cells by their area."""
    attraction: float = 1.0
    """F_ct."""


class Vff:
    """Steers along R = F_t + sum of F_r."""

    def __init__(self, forces: VffForces | None = None) -> None:
        self._forces = forces or VffForces()

    def steer(self, view: View, _speed: float, goal: Goal) -> Decision:
        """The direction of the resulting force."""
        window = view.window
        hits = view.within(goal.distance + window.keep)
        hits = hits[np.searchsorted(hits, 1) :]
        push = repulsions(view.certainty[hits], window.x[hits], window.y[hits], self._forces.repulsion)
        pull = self._forces.attraction * cos(goal.bearing), self._forces.attraction * sin(goal.bearing)
        strength = totals(window.nearest_sector[hits], np.hypot(*push), window.sectors)
        polar = Polar(strength, inf, inf, view.shut, np.zeros_like(view.shut))
        x, y = pull[0] + float(push[0].sum()), pull[1] + float(push[1].sum())
        if view.touching:
            return Decision(None, 0.0, Why.TOUCHING, goal, polar)
        if abs(x) + abs(y) < _NOTHING:
            return Decision(None, 0.0, Why.BALANCED, goal, polar)
        heading = atan2(y, x) if len(hits) else goal.bearing
        sector = round(to_sectors(heading, window.sectors)) % window.sectors
        if view.shut[sector]:
            return Decision(None, 0.0, Why.BLOCKED, goal, polar)
        why = Why.AROUND if len(hits) else Why.TARGET
        return Decision(heading, float(view.known[sector]), why, goal, polar)

    def forget(self) -> None:
        """It remembers nothing."""


def repulsions(certainty: NDArray[np.int16], x: Floats, y: Floats, repulsion: float) -> tuple[Floats, Floats]:
    """F_r = -F_cr C/d^2 (x/d, y/d) of each cell, x and y (m) from the robot."""
    distance = np.hypot(x, y)
    strength = -repulsion * certainty / distance**3
    return strength * x, strength * y
