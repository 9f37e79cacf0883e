"""The directions that a moving robot cannot come to, as an obstacle stands in its turning circle."""

from math import cos, pi, sin, tau

import numpy as np

from echogrid.mapping.steering.sectors import Floats, Indices, Mask
from echogrid.mapping.steering.window import Window

_ROUNDING = 1e-9
"""rad: what stands straight ahead stands on both sides, however the angles were rounded."""


def out_of_reach(window: Window, hits: Indices, yaw: float, radius: float) -> Mask:
    """(sectors,) masked for a robot at that yaw whose tightest curve has that radius (m).

    An obstacle within radius + r_robot + d_safe of the right circle's centre masks all that lies farther
    right than itself, up to straight back; the left circle likewise. Turning in place masks nothing.
    """
    if radius <= 0.0 or not len(hits):
        return np.zeros(window.sectors, np.bool_)
    x, y, aside = window.x.take(hits), window.y.take(hits), _wrapped(window.bearing.take(hits) - yaw)
    east, north = -radius * sin(yaw), radius * cos(yaw)
    reach = (radius + window.keep) ** 2
    in_left = (x - east) ** 2 + (y - north) ** 2 < reach
    in_right = (x + east) ** 2 + (y + north) ** 2 < reach
    left = float(aside[in_left & (aside >= -_ROUNDING)].min(initial=pi))
    right = float(aside[in_right & (aside <= _ROUNDING)].max(initial=-pi))
    sectors = _wrapped(window.directions - yaw)
    back = np.abs(sectors) > pi - _ROUNDING
    beyond = (sectors > left + _ROUNDING) | (sectors < right - _ROUNDING)
    return np.where(back, left < pi and right > -pi, beyond)


def _wrapped(angles: Floats) -> Floats:
    """The same angles in -pi...pi."""
    result: Floats = angles - tau * np.rint(angles / tau)
    return result
