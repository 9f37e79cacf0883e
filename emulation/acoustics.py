"""The physics of an ultrasonic echo as small formulae, and the transducers that the emulated devices carry.

Levels are dB relative to the echo of a large smooth wall on the axis at `level_range`, at full gain. The
gain ramp of a ranger grows with time so that such a wall sounds equally loud up to `ramp_end`; so neither
spreading (1/r for a plane) nor absorption counts up to there, and both count beyond.

The formulae take numbers or arrays of them.
"""

from dataclasses import dataclass
from math import cos, log10, radians, sqrt
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.piston import TWO_WAY_LOSS_AT_NULL, kuc_null_angle, plane_beam_half_width

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


def spreading_loss(ratio: Value, exponent: float) -> Value:
    """Loss, dB, when the range grows by this ratio."""
    return 20.0 * exponent * _log10(ratio)


def absorption_loss(distance: Value, per_metre: float) -> Value:
    """Loss, dB, in the air on the way to a distance, m, and back; `per_metre` is one way, dB/m."""
    return 2.0 * per_metre * distance


def edge_loss(distance: Value) -> Value:
    """Loss, dB, of an edge against a wall at the same distance, m: it spreads faster than the wall."""
    return EDGE_LOSS + spreading_loss(distance, EDGE_SPREADING - PLANE_SPREADING)


def cylinder_loss(distance: Value, radius: Value) -> Value:
    """Loss, dB, of a cylinder against a wall at the same distance, m, from its surface."""
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

    @property
    def beam_half_width(self) -> float:
        """Bearing, rad, to which a smooth wall at `level_range` is heard."""
        return plane_beam_half_width(self.null_angle, self.sensitivity)

    def range_loss(self, distance: Value) -> Value:
        """What a wall at a distance, m, loses against one at `level_range`, dB, after the gain ramp."""
        beyond = _at_least(self.ramp_end, distance)
        spreading = spreading_loss(beyond / self.level_range, PLANE_SPREADING)
        return spreading + absorption_loss(beyond - self.level_range, self.absorption)


_SPEED_AT_20 = speed_of_sound(20.0)

POLAROID = Transducer(
    null_angle=kuc_null_angle(0.0192, 49_400.0, _SPEED_AT_20),
    sensitivity=30.0,
    blanking=0.15,
    reach=10.7,
    level_range=10.7,
    ramp_end=10.7,
    absorption=1.6,
)
"""Electrostatic, 49.4 kHz, with the 6500 board: gain steps all the way to 35 ft, blanking cut to 6 in."""

SRF08 = Transducer(
    null_angle=kuc_null_angle(0.0075, 40_000.0, _SPEED_AT_20),
    sensitivity=30.0,
    blanking=0.0,
    reach=6.0,
    level_range=0.39,
    ramp_end=0.01,
    absorption=1.3,
)
"""Open 16 mm capsules, 40 kHz. The chip itself applies its gain ramp and makes of near echoes what it can.

With 30 dB a smooth wall is heard to 41 deg at 0.4 m, to 25 deg at 2 m and on the axis to 4 m. That is 10 dB
short of the 6 m in its data sheet: users turn it down so far, or the floor and every door frame answers.
"""

A02YYUW = Transducer(
    null_angle=radians(32.3),
    sensitivity=30.0,
    blanking=0.0,
    reach=4.5,
    level_range=1.0,
    ramp_end=1.0,
    absorption=1.3,
)
"""Closed 40 kHz capsule: heard 30 deg to either side (the 60 deg of its data sheet) while the ramp lasts.

A wall is heard to 25 deg at 2 m and 15 deg at the 4.5 m which are its reach.
"""
