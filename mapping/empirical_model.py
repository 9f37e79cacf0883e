"""A sonar model from data: how often cells so far from an echo, and so far off the axis, were occupied.

Moravec & Elfes' evidence patterns, learned from pings whose poses and surroundings are known. With n of a
bin's cells and N of all cells that were spoken of,

    dL = ln(n_occupied/n_empty) - ln(N_occupied/N_empty),

each count one higher than it is (Laplace), and 0 in a bin of fewer than 30.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import radians

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.cone import Cone, Floats
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import SonarModel
from echogrid.mapping.sounding import Sounding

FEWEST = 30
"""Cells in a bin that is believed."""

Counts = NDArray[np.int64]
Index = tuple[NDArray[np.intp], ...]


@dataclass(frozen=True, slots=True)
class Bins:
    """The borders of the bins, rising; what lies outside them says nothing."""

    offset: tuple[float, ...]
    """m, r - s: from the echo to the cell; the last is the half band beyond the echo."""
    bearing: tuple[float, ...]
    """rad, |alpha|; the last is the half angle of the cone."""
    distance: tuple[float, ...]
    """m: the reading s of an echo; of silence the distance r of the cell."""

    def __post_init__(self) -> None:
        for borders in (self.offset, self.bearing, self.distance):
            if len(borders) < 2 or any(np.diff(borders) <= 0.0):
                raise ValueError("bins have at least two borders, each above the one before")
        if self.offset[-1] <= 0.0:
            raise ValueError("the bins of the offset reach beyond the echo")

    def believed(self, sounding: Sounding) -> Sounding:
        """The ping with the cone and the band of the bins."""
        ranger = replace(sounding.ranger, half_angle=self.bearing[-1])
        return replace(sounding, ranger=ranger, tolerance=self.offset[-1])

    @property
    def echo_shape(self) -> tuple[int, int, int]:
        """Bins of offset, bearing and reading."""
        return len(self.offset) - 1, len(self.bearing) - 1, len(self.distance) - 1

    @property
    def silence_shape(self) -> tuple[int, int]:
        """Bins of bearing and distance."""
        return self.echo_shape[1:]

    def within(self, cone: Cone) -> tuple[Index, NDArray[np.bool_]]:
        """The bins of those of the cone's cells that lie in one, and (n,) which do: bins of an echo or of
        silence, as the ping was."""
        values = [cone.bearing, np.full(len(cone.rows), cone.reading) if cone.echo else cone.distance]
        borders = [self.bearing, self.distance]
        if cone.echo:
            values, borders = [cone.distance - cone.reading, *values], [self.offset, *borders]
        places = [
            np.searchsorted(edges, value, "right") - 1 for edges, value in zip(borders, values, strict=True)
        ]
        inside = np.ones(len(cone.rows), np.bool_)
        for edges, place in zip(borders, places, strict=True):
            inside &= (place >= 0) & (place < len(edges) - 1)
        return tuple(place[inside] for place in places), inside


USUAL = Bins(
    (-4.0, -2.0, -1.0, -0.5, -0.3, -0.2, -0.12, -0.04, 0.04, 0.12, 0.2),
    tuple(radians(degrees) for degrees in (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.5, 15.0)),
    (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0),
)
"""For a ranger of some metres' reach in cells of 5 to 10 cm."""


@dataclass(frozen=True, slots=True)
class Empirical:
    """The model: log-likelihood ratios, nats, in bins. Silence is worth what it was found to be worth."""

    bins: Bins
    of_echo: Floats
    """(offset, bearing, reading)."""
    of_silence: Floats
    """(bearing, distance)."""

    def __post_init__(self) -> None:
        shapes = self.bins.echo_shape, self.bins.silence_shape
        if (self.of_echo.shape, self.of_silence.shape) != shapes:
            raise ValueError(f"the tables' shapes are {shapes[0]} and {shapes[1]}, as the bins'")
        if not (np.isfinite(self.of_echo).all() and np.isfinite(self.of_silence).all()):
            raise ValueError("the tables hold finite numbers")

    def believed(self, sounding: Sounding) -> Sounding:
        """The ping with the cone and the band of the bins."""
        return self.bins.believed(sounding)

    def echo(self, cone: Cone) -> Floats:
        """(n,) ln(P(s|Occupied)/P(s|Empty)); of silence, if nothing came back."""
        return self._found(self.of_echo if cone.echo else self.of_silence, cone)

    def silence(self, cone: Cone) -> Floats:
        """(n,) The same of silence."""
        return self._found(self.of_silence, cone)

    def tempered(self, factor: float) -> "Empirical":
        """A model which says so many times as much: pings that follow each other are not independent."""
        return replace(self, of_echo=self.of_echo * factor, of_silence=self.of_silence * factor)

    def _found(self, table: Floats, cone: Cone) -> Floats:
        index, inside = self.bins.within(cone)
        result = np.zeros(len(cone.rows))
        result[inside] = table[index]
        return result


@dataclass(frozen=True, slots=True)
class EmpiricalOfEach:
    """Every ranger's own model, by its name; another one for those which have none."""

    own: Mapping[str, Empirical]
    otherwise: SonarModel

    def believed(self, sounding: Sounding) -> Sounding:
        """The ping as its ranger's model believes it."""
        return self._of(sounding.ranger).believed(sounding)

    def echo(self, cone: Cone) -> Floats:
        """(n,) ln(P(s|Occupied)/P(s|Empty))."""
        return self._of(cone.ranger).echo(cone)

    def silence(self, cone: Cone) -> Floats:
        """(n,) The same of silence."""
        return self._of(cone.ranger).silence(cone)

    def _of(self, ranger: Ranger) -> SonarModel:
        return self.own.get(ranger.name, self.otherwise)


class Tally:
    """Counts occupied and empty cells in bins, and makes the model from them."""

    def __init__(self, bins: Bins = USUAL) -> None:
        self.bins = bins
        self.echo: Counts = np.zeros((2, *bins.echo_shape), np.int64)
        """(empty and occupied, offset, bearing, reading)."""
        self.silence: Counts = np.zeros((2, *bins.silence_shape), np.int64)
        """(empty and occupied, bearing, distance)."""

    def add(self, cone: Cone, occupied: NDArray[np.bool_], known: NDArray[np.bool_]) -> None:
        """Count a ping's cells, cast as the bins believe it. `occupied` (n,) is the truth of each cell, where
        it is `known` (n,)."""
        index, inside = self.bins.within(cone)
        told = known[inside]
        truth = occupied[inside].astype(np.intp)[told]
        counts = self.echo if cone.echo else self.silence
        np.add.at(counts, (truth, *(axis[told] for axis in index)), 1)

    def model(self) -> Empirical:
        """The log-likelihood ratios of what was counted."""
        everywhere = _flat(self.echo) + _flat(self.silence)
        base = _laplace(everywhere)
        return Empirical(self.bins, _ratios(self.echo, base), _ratios(self.silence, base))


def _flat(counts: Counts) -> Counts:
    result: Counts = counts.reshape(2, -1).sum(axis=1)
    return result


def _laplace(counts: Counts) -> Floats:
    """ln of occupied over empty, each one higher."""
    result: Floats = np.log(counts[1] + 1.0) - np.log(counts[0] + 1.0)
    return result


def _ratios(counts: Counts, base: Floats) -> Floats:
    return np.where(counts.sum(axis=0) >= FEWEST, _laplace(counts) - base, 0.0)
