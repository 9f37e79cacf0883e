"""The map by which all pings together are the most likely: a forward model, instead of an inverse one.

Thrun 2003, "Learning occupancy grid maps with forward sensor models". Every cell has a hazard h >= 0, what
stops the sound there. Sound passes what lies before an echo with probability e^-S, S = sum w h over those
cells, and is stopped in the band with 1 - e^-S_b, so that an echo has the likelihood

    L = (1 - e) e^-S (1 - e^-S_b)/(2 band) + e/R         e: how often an echo comes from anything else
    L = (1 - m) e^-S + m                                 of silence; m: how often a wall is silent

with w = exp(-(alpha/9 deg)^2). The hazards climb the slope of the sum of ln L (Adam; Kingma & Ba 2015). So
one wall explains many echoes, and what it explains needs no other. It takes all pings at once, and is slow.
"""

from dataclasses import dataclass
from math import radians
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.cone import cast
from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.sounding import Sounding

Floats = NDArray[np.float64]

BEAM = radians(9.0)


@dataclass(frozen=True, slots=True)
class Settings:
    """Of the model, and of how it is fitted."""

    stray: float = 0.5
    """e."""
    unheard: float = 0.8
    """m."""
    weight: float = 0.5
    """All w are multiplied by it."""
    band: float = 0.12
    """m: half of an echo's band, in its likelihood."""
    sparse: float = 0.02
    """The slope by which hazards fall that nothing speaks for (l1)."""
    rate: float = 0.15
    steps: int = 70


USUAL = Settings()
_START = -3.0
"""ln(e^h - 1) of a cell of which nothing is known."""
_MOMENTS = 0.9, 0.999
_LEAST = 1e-8
_FARTHEST = 8.0


class Pings(NamedTuple):
    """All cells of all pings in a row: arrays (n,), and (pings,)."""

    cells: NDArray[np.intp]
    """(n,) flat indices."""
    weights: Floats
    """(n,)."""
    in_band: NDArray[np.bool_]
    """(n,)."""
    starts: NDArray[np.intp]
    """(pings,) where the cells of each begin."""
    echo: NDArray[np.bool_]
    """(pings,)."""
    reach: Floats
    """(pings,) m, R."""


class Slope(NamedTuple):
    """The likelihood of each ping, and how the sum of their logarithms rises with the hazards in its cone."""

    likelihood: Floats
    """(pings,)."""
    rise: Floats
    """(n,) d ln L/dh of each cell of each ping."""


def slope(pings: Pings, hazard: Floats, s: Settings = USUAL) -> Slope:
    """At these hazards (cells,)."""
    stopped = pings.weights * hazard[pings.cells]
    passes = np.exp(-np.add.reduceat(np.where(pings.in_band, 0.0, stopped), pings.starts))
    through = np.exp(-np.add.reduceat(np.where(pings.in_band, stopped, 0.0), pings.starts))
    density = (1.0 - s.stray) * passes / (2.0 * s.band)
    heard = density * (1.0 - through)
    silent = (1.0 - s.unheard) * passes
    likelihood = np.where(pings.echo, heard + s.stray / pings.reach, silent + s.unheard)
    before = -np.where(pings.echo, heard, silent) / likelihood
    within = np.where(pings.echo, density * through, 0.0) / likelihood
    many = np.diff(pings.starts, append=len(pings.cells))
    rise = pings.weights * np.where(pings.in_band, np.repeat(within, many), np.repeat(before, many))
    return Slope(likelihood, rise)


def fitted(pings: Pings, cells: int, s: Settings = USUAL) -> Floats:
    """(cells,) The hazards that make the pings the most likely."""
    theta = np.full(cells, _START)
    first, second = np.zeros(cells), np.zeros(cells)
    for step in range(1, s.steps + 1):
        rise = np.bincount(pings.cells, slope(pings, np.logaddexp(0.0, theta), s).rise, cells)
        gradient = (rise - s.sparse) / (1.0 + np.exp(-theta))
        first = _MOMENTS[0] * first + (1.0 - _MOMENTS[0]) * gradient
        second = _MOMENTS[1] * second + (1.0 - _MOMENTS[1]) * gradient**2
        mean, spread = first / (1.0 - _MOMENTS[0] ** step), second / (1.0 - _MOMENTS[1] ** step)
        theta = np.clip(theta + s.rate * mean / (np.sqrt(spread) + _LEAST), -_FARTHEST, _FARTHEST)
    hazards: Floats = np.logaddexp(0.0, theta)
    return hazards


class ForwardGrid:
    """A theory that remembers all pings, and fits the hazards when it is asked. P(Occupied) = 1 - e^-h."""

    def __init__(self, geometry: GridGeometry, settings: Settings = USUAL) -> None:
        self.geometry = geometry
        self._settings = settings
        self._parts: list[Pings] = []
        self._seen: NDArray[np.bool_] = np.zeros(geometry.shape, np.bool_)

    def update(self, sounding: Sounding) -> Patch | None:
        """Remember a ping; the patch of which it speaks, None if that holds no cell."""
        cone = cast(self.geometry, sounding)
        if not len(cone.rows):
            return None
        self._seen[cone.rows, cone.cols] |= cone.echo
        weights = self._settings.weight * np.exp(-((cone.bearing / BEAM) ** 2))
        self._parts.append(
            Pings(
                cone.rows * self.geometry.cols + cone.cols,
                weights,
                cone.occupied,
                np.zeros(1, np.intp),
                np.array([cone.echo]),
                np.array([sounding.ranger.farthest]),
            )
        )
        return cone.patch

    def occupancy(self) -> NDArray[np.float32]:
        """(rows, cols) P(Occupied), row 0 = south; 0.5 where unknown."""
        if not self._parts:
            return np.full(self.geometry.shape, 0.5, np.float32)
        joined = Pings._make(np.concatenate(each) for each in zip(*self._parts, strict=True))
        many = [len(each.cells) for each in self._parts]
        pings = joined._replace(starts=np.cumsum([0, *many[:-1]]))
        hazard = fitted(pings, self._seen.size, self._settings).reshape(self.geometry.shape)
        return np.where(self._seen, 1.0 - np.exp(-hazard), 0.5).astype(np.float32)

    def unknown(self) -> NDArray[np.bool_]:
        """(rows, cols) True where no echo has spoken."""
        return ~self._seen

    def copy(self) -> Self:
        """An independent twin."""
        twin = type(self)(self.geometry, self._settings)
        twin._parts, twin._seen = list(self._parts), self._seen.copy()
        return twin
