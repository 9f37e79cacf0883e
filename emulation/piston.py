"""The beam of a round flat piston in a baffle: D = 2 J1(ka sin b) / (ka sin b), b the bearing."""

from math import asin, pi, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

TWO_WAY_LOSS_AT_NULL = 80.0 * float(np.log10(np.e))
"""dB: -20 log10 exp(-4), from the amplitude exp(-4 b^2 / theta0^2) of Barshan & Kuc 1990."""

_J1_FIRST_ZERO = 3.8317059702075125
_SAMPLES = 128
_PHASES = np.arange(_SAMPLES) * (2.0 * pi / _SAMPLES)
_MINUS_3_DB = 10.0 ** (-3.0 / 20.0)


def bessel_j1(x: ArrayLike) -> NDArray[np.float64]:
    """J1 by Bessel's integral, to 1e-12 for |x| < 60.

    The trapezoid rule over the full period of a smooth function: its error is about J127(x).
    """
    column = np.asarray(x, dtype=np.float64)[..., np.newaxis]
    return np.asarray(np.cos(_PHASES - column * np.sin(_PHASES)).mean(axis=-1))


def directivity(ka: float, bearing: ArrayLike) -> NDArray[np.float64]:
    """Amplitude relative to the axis, one way; negative in every second side lobe."""
    x = ka * np.sin(np.asarray(bearing, dtype=np.float64))
    small = np.abs(x) < 1e-6
    x = np.where(small, 1.0, x)
    return np.where(small, 1.0, 2.0 * bessel_j1(x) / x)


def wave_number_times_radius(radius: float, frequency: float, speed: float) -> float:
    """ka; m, Hz and m/s."""
    return 2.0 * pi * frequency / speed * radius


def first_null(ka: float) -> float:
    """Bearing, rad, of the first zero of the beam."""
    return asin(_J1_FIRST_ZERO / ka)


def half_power_angle(ka: float) -> float:
    """Bearing, rad, at which the beam has lost 3 dB one way; by bisection."""
    low, high = 0.0, first_null(ka)
    while high - low > 1e-14:
        middle = 0.5 * (low + high)
        if directivity(ka, middle) > _MINUS_3_DB:
            low = middle
        else:
            high = middle
    return low


def kuc_null_angle(radius: float, frequency: float, speed: float) -> float:
    """theta0 = asin(0.61 wavelength / radius), rad: the null as Kuc & Siegel 1987 round it."""
    return asin(0.61 * speed / (frequency * radius))


def null_angle_of_beam(full_beam: float) -> float:
    """theta0, rad, of a beam that has lost 6 dB one way at half of this angle, rad, to either side.

    For the 15 deg of a Polaroid this is the null that its radius and frequency give.
    """
    return 0.5 * full_beam * sqrt(TWO_WAY_LOSS_AT_NULL / 12.0)


def plane_beam_half_width(null_angle: float, allowance: float) -> float:
    """Bearing, rad, at which the two-way Gaussian beam of Kuc & Siegel has lost `allowance` dB."""
    return null_angle * sqrt(max(allowance, 0.0) / TWO_WAY_LOSS_AT_NULL)
