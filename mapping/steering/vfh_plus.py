"""VFH+ (Ulrich & Borenstein 1998): the robot's width, its turning circles, and what a direction costs."""

from dataclasses import dataclass
from math import tau

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.pose import wrap_angle
from echogrid.mapping.steering.decision import Candidate, Decision, Polar, Why
from echogrid.mapping.steering.goal import Goal
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.obstacles import MOST, View
from echogrid.mapping.steering.sectors import Floats, Mask, apart, openings, to_sectors
from echogrid.mapping.steering.turning import out_of_reach
from echogrid.mapping.steering.window import Window

_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class Costs:
    """What a sector's distance costs."""

    target: float = 5.0
    """mu_1: from the goal."""
    heading: float = 2.0
    """mu_2: from where the robot points now."""
    previous: float = 2.0
    """mu_3: from what was chosen last."""
    unknown: float = 40.0
    """Of a direction of which nothing is known: as much as eight sectors off the goal."""

    def __post_init__(self) -> None:
        if not self.target > self.heading + self.previous:
            raise ValueError("mu_1 must be above mu_2 + mu_3, or the robot would not mind its goal")


@dataclass(frozen=True, slots=True)
class VfhPlusNumbers:
    """The thresholds, as distances at which one cell of full certainty blocks a sector, and widths."""

    blocking: float = 1.1
    """m, tau_high."""
    freeing: float = 1.3
    """m, tau_low."""
    wide: int = 16
    """s_max, sectors: a narrower opening is taken in its middle."""
    costs: Costs = Costs()

    def __post_init__(self) -> None:
        if not 0.0 < self.blocking <= self.freeing:
            raise ValueError(
                "what frees a sector must lie no nearer than what blocks it: blocking <= freeing"
            )


class VfhPlus:
    """Remembers which sectors were blocked, and what it chose: both keep it from dithering."""

    def __init__(self, window: Window, limits: Limits, numbers: VfhPlusNumbers | None = None) -> None:
        self._window = window
        self._limits = limits
        self._numbers = numbers or VfhPlusNumbers()
        self._factor = factors(window.squared, window.half)
        self.high, self.low = self._one_cell(self._numbers.blocking), self._one_cell(self._numbers.freeing)
        """tau_high and tau_low."""
        self._blocked: Mask = np.zeros(window.sectors, np.bool_)
        self._previous: float | None = None

    def steer(self, view: View, speed: float, goal: Goal) -> Decision:
        """The open direction that costs least."""
        polar = self._polar(view, speed, goal)
        self._blocked = polar.blocked & ~view.shut
        shut = polar.blocked | polar.masked
        if view.touching or shut.all():
            self._previous = None
            return Decision(None, 0.0, Why.TOUCHING if view.touching else Why.BLOCKED, goal, polar)
        n = self._window.sectors
        target = to_sectors(goal.bearing, n)
        weighed = self._weighed(directions(shut, target, self._numbers.wide), target, view)
        chosen = self._previous = weighed[0].sector
        straight = chosen == target
        return Decision(
            goal.bearing if straight else wrap_angle(chosen * tau / n),
            float(view.known[round(chosen) % n]),
            Why.TARGET if straight else Why.AROUND,
            goal,
            polar,
            weighed,
        )

    def forget(self) -> None:
        """Begin anew: nothing was blocked, nothing chosen."""
        self._blocked = np.zeros(self._window.sectors, np.bool_)
        self._previous = None

    def _polar(self, view: View, speed: float, goal: Goal) -> Polar:
        """The primary histogram, the binary one with hysteresis, and what the turning circles mask."""
        window = self._window
        hits = view.within(goal.distance + window.keep)
        certainty = view.certainty.take(hits).astype(np.float64)
        weights = certainty * certainty * self._factor.take(hits)
        density = spread(weights, window.first.take(hits), window.last.take(hits), window.sectors)
        blocked = (density > self.high) | (self._blocked & (density >= self.low)) | view.shut
        masked = out_of_reach(window, hits, view.robot.yaw, self._limits.turning_radius(speed))
        return Polar(density, self.low, self.high, blocked, masked)

    def _weighed(self, sectors: list[float], target: float, view: View) -> tuple[Candidate, ...]:
        """The directions with what they cost, the cheapest first."""
        n, costs = self._window.sectors, self._numbers.costs
        heading = to_sectors(view.robot.yaw, n)
        previous = heading if self._previous is None else self._previous
        return tuple(
            sorted(
                (
                    Candidate(
                        sector,
                        cost(sector, (target, heading, previous), costs, n)
                        + costs.unknown * (1.0 - float(view.known[round(sector) % n])),
                    )
                    for sector in sectors
                ),
                key=lambda candidate: candidate.cost,
            )
        )

    def _one_cell(self, distance: float) -> float:
        """m of a cell of full certainty there, or at the window's border if that is nearer."""
        cells = min(distance / self._window.resolution, float(self._window.half))
        return MOST**2 * float(factors(np.array([cells**2]), self._window.half)[0])


def factors(squared: Floats, half: int) -> Floats:
    """a - b d^2 of cells at d^2 (in cells), b = 1, a - b ((w_s - 1)/2)^2 = 1: whole numbers, as d^2 is."""
    return half**2 + 1.0 - squared


def spread(weights: Floats, first: NDArray[np.intp], last: NDArray[np.intp], sectors: int) -> Floats:
    """(n,) the sum of the weights of all cells whose sectors first...last (places of 0...2n) hold each.

    By what begins and ends where; exact, as long as the weights are whole numbers.
    """
    steps = np.bincount(first, weights, 2 * sectors + 1) - np.bincount(last + 1, weights, 2 * sectors + 1)
    twice = np.cumsum(steps)
    return twice[:sectors] + twice[sectors : 2 * sectors]


def directions(shut: Mask, target: float, wide: int) -> list[float]:
    """The sectors worth weighing: of a narrow opening its middle; of a wide one s_max/2 inside each border,
    and the goal if it lies between these."""
    found: list[float] = []
    for opening in openings(shut):
        if opening.width < wide:
            found.append((opening.right + opening.left) / 2.0)
            continue
        right, left = opening.right + wide / 2.0, opening.left - wide / 2.0
        found += [right, left]
        if (target - right) % len(shut) <= left - right:
            found.append(target)
    return found or [target]


def cost(sector: float, others: tuple[float, float, float], costs: Costs, sectors: int) -> float:
    """g = mu_1 D(c, k_target) + mu_2 D(c, heading) + mu_3 D(c, k_previous), D the short way round."""
    target, heading, previous = (apart(sector, other, sectors) for other in others)
    return costs.target * target + costs.heading * heading + costs.previous * previous
