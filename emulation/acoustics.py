"""The physics of an ultrasonic echo as small formulae, and what a transducer is.

Levels are dB relative to the echo of a large smooth wall on the axis at `level_range`, at full gain. The
gain ramp of a ranger grows with time so that such a wall sounds equally loud up to `ramp_end`; so neither
spreading (1/r for a plane) nor absorption counts up to there, and both count beyond.

The formulae take numbers or arrays of them.
"""

from dataclasses import dataclass
from math import cos, log10, sqrt
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.piston import TWO_WAY_LOSS_AT_NULL, plane_beam_half_width

FloatArray = NDArray[np.float64]
Value = TypeVar("Value", float, FloatArray)

PLANE_SPREADING = 1.0
"""Exponent: the echo's amplitude falls as r to the minus this. Corners are the same."""
EDGE_SPREADING = 1.5
POINT_SPREADING = 2.0

EDGE_LOSS = 20.0
"""dB: what a diffracting edge at 1 m returns less than a wall there."""
ROUGH_LOSS = 14.0
"""dB: what a rough facet at normal incidence returns less than a wall there."""
BOUNCE_LOSS = 4.0
"""dB for each mirror on the way."""

_BAND = 0.05
"""A capsule rings within so much of its frequency, in proportion, and hears nothing else."""


def speed_of_sound(temperature: float) -> float:
    """Speed in dry air, m/s, at degC."""
    return 331.3 * sqrt(1.0 + temperature / 273.15)


def range_of_flight(time_of_flight: float, temperature: float) -> float:
    """Range, m, of an echo that took this long, s, there and back."""
    return 0.5 * speed_of_sound(temperature) * time_of_flight


def wavelength(frequency: float, speed: float) -> float:
    """Wavelength, m; Hz and m/s."""
    return speed / frequency


def rayleigh_height(length: float, incidence: float) -> float:
    """Height of roughness, m, from which a surface scatters: wavelength / (8 cos i)."""
    return length / (8.0 * cos(incidence))


def beam_loss(bearing: Value, null_angle: float) -> Value:
    """Two-way loss, dB, off the axis: amplitude exp(-4 b^2 / theta0^2) (Barshan & Kuc 1990)."""
    return TWO_WAY_LOSS_AT_NULL / null_angle**2 * bearing**2


def one_way_beam_loss(bearing: Value, null_angle: float) -> Value:
    """Loss, dB, off the axis of one of two transducers: the half of what both ways of an echo take."""
    return 0.5 * beam_loss(bearing, null_angle)


def spreading_loss(ratio: Value, exponent: float) -> Value:
    """Loss, dB, when the range grows by this ratio."""
    return 20.0 * exponent * _log10(ratio)


def absorption_loss(distance: Value, per_metre: float) -> Value:
    """Loss, dB, in the air on the way to a distance, m, and back; `per_metre` is one way, dB/m."""
    return 2.0 * per_metre * distance


def edge_loss(distance: Value) -> Value:
    """Loss, dB, of an edge against a wall at the same distance, m: it spreads faster than the wall."""
    return EDGE_LOSS + spreading_loss(distance, EDGE_SPREADING - PLANE_SPREADING)


def harmonic_mean(there: float, back: float) -> float:
    """Of two ways, m: the distance at which an echo would lose what a scatterer between them takes.

    An edge makes of a wave from `there` one whose amplitude falls as sqrt(there / (back * (there + back)));
    a mirror would leave 1 / (there + back). Their ratio has only this mean in it, and so has a cylinder's
    (Keller 1962).
    """
    return 2.0 * there * back / (there + back)


def cylinder_loss(distance: Value, radius: Value) -> Value:
    """Loss, dB, of a cylinder against a wall at the same distance, m, from its surface.

    Struck at a slant, its radius counts by the cosine of incidence.
    """
    return -10.0 * _log10(radius / (radius + distance))


def rough_loss(incidence_cosine: Value) -> Value:
    """Loss, dB, of a rough facet struck at this cosine of incidence (Lambert's law)."""
    return ROUGH_LOSS - 20.0 * _log10(incidence_cosine)


def _log10(value: Value) -> Value:
    return log10(value) if isinstance(value, float) else np.log10(value)


def _at_least(least: float, value: Value) -> Value:
    return max(least, value) if isinstance(value, float) else np.maximum(least, value)


@dataclass(frozen=True, slots=True)
class Transducer:
    """One capsule with its receiver, as the acoustics see it."""

    null_angle: float
    """theta0, rad: Kuc's first null of the beam."""
    sensitivity: float
    """S, dB: an echo this much weaker than a wall on the axis is at the threshold."""
    blanking: float
    """m: deaf to anything nearer, while the membrane still rings."""
    reach: float
    """m: the receiver stops listening here."""
    level_range: float
    """m: where a wall on the axis is S above the threshold."""
    ramp_end: float
    """m: where the gain ramp ends."""
    absorption: float
    """dB/m, one way, at its frequency."""
    frequency: float
    """Hz."""

    @property
    def beam_half_width(self) -> float:
        """Bearing, rad, to which a smooth wall at `level_range` is heard."""
        return plane_beam_half_width(self.null_angle, self.sensitivity)

    def hears(self, frequency: float) -> bool:
        """Whether the sound of another transducer, Hz, is in its band."""
        return abs(frequency - self.frequency) <= _BAND * max(frequency, self.frequency)

    def way_loss(self, distance: Value) -> Value:
        """What a wall at a distance, m, loses against one at `level_range`, dB, at full gain."""
        spreading = spreading_loss(distance / self.level_range, PLANE_SPREADING)
        return spreading + absorption_loss(distance - self.level_range, self.absorption)

    def range_loss(self, distance: Value) -> Value:
        """What a wall at a distance, m, loses against one at `level_range`, dB, after the gain ramp."""
        return self.way_loss(_at_least(self.ramp_end, distance))

    def ramp_loss(self, distance: Value) -> Value:
        """dB: what the gain ramp still lacks when an echo of a distance, m, comes in."""
        return self.range_loss(distance) - self.way_loss(distance)
