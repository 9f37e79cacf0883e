"""A sonar model from the transducer's physics: the beam of a piston, and the error of timing.

A round membrane of radius a sends as D(theta) = 2 J1(ka sin theta)/(ka sin theta), k = 2 pi/lambda, and hears
with the same pattern, so that an echo's amplitude goes with D^2 (Kuc & Siegel 1987 take a Gaussian for it).

What a ping says of a cell follows from the probability p_d with which an obstacle there answers; nothing else
is chosen for each region. D^2 is 1 on the axis, where `HEARD` says how often smooth walls answer:

    p_d = HEARD D^2 (1 - (r/R)^2)

Silence, and the quiet before an echo (region II), say ln((1 - p_d)/(1 - p_fa)) of every cell. An echo (region
I) comes from this cell, or from any other of its arc. With q the probability that one of the others answers,
or that the echo is false, it says ln((p_d + (1 - p_d) q)/q); p_d is there that on the arc, without the fall
with range, as something did answer. Of all others a part, `DENSITY`, are obstacles: q = 1 - (1 - p_fa)
exp(-DENSITY sum p_d). So a longer arc, which comes of a greater range or a wider beam, says less of each of
its cells.
"""

from dataclasses import dataclass, field, replace
from math import asin, pi

import numpy as np

from echogrid.mapping.cone import Cone, Floats
from echogrid.mapping.sonar_model import FALSE, heard, no_echo_log_odds
from echogrid.mapping.sounding import Sounding

DENSITY = 0.05
"""The part of all cells that are obstacles."""
DETECTED_DB = 30.0
"""How far below that on the axis an echo may lie and still be heard: this is where the cone ends."""

_NULL = 3.8317059702075125
"""The first zero of J1."""
_STEPS = 64
"""Of the integral: the midpoint rule is exact to rounding for x below some 50."""


def bessel_j1(x: Floats) -> Floats:
    """(n,) J1(x) = 1/pi integral from 0 to pi of cos(t - x sin t) dt (Abramowitz & Stegun 9.1.21)."""
    t = (np.arange(_STEPS) + 0.5) * pi / _STEPS
    result: Floats = np.cos(t - np.multiply.outer(np.asarray(x), np.sin(t))).mean(axis=-1)
    return result


def piston(x: Floats) -> Floats:
    """(n,) 2 J1(x)/x, the amplitude of a piston's beam at x = ka sin(theta); 1 at 0."""
    x = np.asarray(x, np.float64)
    small = np.abs(x) < 1e-4
    safe = np.where(small, 1.0, x)
    return np.where(small, 1.0, 2.0 * bessel_j1(safe) / safe)


@dataclass(frozen=True, slots=True)
class Analytical:
    """The model of a round transducer. `radius` and `wavelength` in m."""

    radius: float
    wavelength: float
    _half_angle: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not (self.radius > 0.0 and self.wavelength > 0.0):
            raise ValueError("a transducer's radius and wavelength are above 0")
        object.__setattr__(self, "_half_angle", self.angle_at(-DETECTED_DB / 2.0))

    @property
    def ka(self) -> float:
        """The radius in waves, times 2 pi."""
        return 2.0 * pi * self.radius / self.wavelength

    @property
    def half_angle(self) -> float:
        """rad, beta: where the echo of a plane is `DETECTED_DB` below that on the axis."""
        return self._half_angle

    @property
    def null(self) -> float | None:
        """rad: the first angle at which nothing is sent; None for a transducer too small to have one."""
        return asin(_NULL / self.ka) if self.ka > _NULL else None

    def amplitude(self, bearing: Floats) -> Floats:
        """(n,) D, one way, as a part of that on the axis; the side lobes' sign is kept."""
        return piston(self.ka * np.sin(bearing))

    def angle_at(self, decibels: float) -> float:
        """rad: where the main lobe has fallen so far (below 0), one way; at most 89 degrees."""
        least, low, high = 10.0 ** (decibels / 20.0), 0.0, self.null or np.radians(89.0)
        if self.amplitude(np.array([high]))[0] > least:
            return float(high)
        for _ in range(60):
            middle = (low + high) / 2.0
            above = self.amplitude(np.array([middle]))[0] > least
            low, high = (middle, high) if above else (low, middle)
        return float(low)

    def believed(self, sounding: Sounding) -> Sounding:
        """The ping with the beam's own cone, and the band of timing alone: cast() makes it two standard
        deviations of max(1 cm, 1 %) thick to either side, and half a cell's diagonal at least."""
        ranger = replace(sounding.ranger, half_angle=self.half_angle)
        return replace(sounding, ranger=ranger, tolerance=0.0)

    def echo(self, cone: Cone) -> Floats:
        """(n,) ln(P(s|Occupied)/P(s|Empty))."""
        answer = heard(cone.ranger) * self.amplitude(cone.bearing) ** 2
        on_arc = np.where(cone.occupied, answer, 0.0)
        others = 1.0 - (1.0 - FALSE) * np.exp(-DENSITY * (on_arc.sum() - on_arc))
        ratio: Floats = np.log(answer + (1.0 - answer) * others) - np.log(others)
        return np.where(cone.occupied, ratio, self.silence(cone))

    def silence(self, cone: Cone) -> Floats:
        """(n,) The same of silence."""
        near = np.maximum(1.0 - (cone.distance / cone.ranger.farthest) ** 2, 0.0)
        return no_echo_log_odds(heard(cone.ranger) * self.amplitude(cone.bearing) ** 2 * near)
