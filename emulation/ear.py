"""Where a transducer hears at all: bounds on bearing and range from what an echo may lose."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import pi, tan

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.acoustics import ROUGH_LOSS, Transducer, beam_loss, edge_loss
from echogrid.emulation.piston import plane_beam_half_width
from echogrid.emulation.vista import TOUCH

FloatArray = NDArray[np.float64]

_FACET_SPACING = pi / 90.0
_HALVINGS = 60
_NEAREST = 0.01
"""m: nothing comes so near to the capsule."""


@dataclass(frozen=True, eq=False, slots=True)
class Ear:
    """A transducer for which an echo that lost more than `allowance` dB does not count.

    Its bounds keep all that may be heard, so that only little need be looked at closely.
    """

    transducer: Transducer
    allowance: float
    """dB."""
    beam_slope: float
    """Tangent of the bearing beyond which nothing is loud enough at any range, nor anything from behind."""
    reach: float
    """m: a wall or corner farther off is too faint even on the axis;"""
    edge_reach: float
    """so is an edge,"""
    fan_reach: float
    """and a rough wall, even if it is square to the axis."""
    fan: FloatArray
    """(k, 2): unit vectors, ahead and left, of the rays which sample rough walls over the whole beam."""
    fan_losses: FloatArray
    """(k,) dB: what the beam takes from each."""
    fan_slope: float
    """Tangent of half of its angle."""
    ramp_loss: float
    """dB: what range takes from all that comes before the end of the gain ramp."""

    def range_loss(self, distance: float) -> float:
        """The transducer's own, dB, at a distance, m."""
        early = distance <= self.transducer.ramp_end
        return self.ramp_loss if early else self.transducer.range_loss(distance)


@lru_cache(maxsize=64)
def ear(transducer: Transducer, allowance: float) -> Ear:
    """The ear of a transducer, whose beam must be less than 90 deg to either side."""

    def edge_at(distance: float) -> float:
        return edge_loss(max(distance, TOUCH)) + transducer.range_loss(distance)

    half_width = transducer.beam_half_width
    least = transducer.range_loss(max(transducer.blanking, _NEAREST))
    bearings = _fan(half_width)
    return Ear(
        transducer,
        allowance,
        tan(min(plane_beam_half_width(transducer.null_angle, allowance - least), 0.5 * pi)),
        farthest(lambda distance: transducer.range_loss(distance) <= allowance, transducer.reach),
        farthest(lambda distance: edge_at(distance) <= allowance, transducer.reach),
        farthest(
            lambda distance: transducer.range_loss(distance) + ROUGH_LOSS <= allowance, transducer.reach
        ),
        np.array((np.cos(bearings), np.sin(bearings))).T.copy(),
        beam_loss(bearings, transducer.null_angle),
        tan(half_width),
        transducer.range_loss(transducer.ramp_end),
    )


def _fan(half_width: float) -> FloatArray:
    """(k,) rad: bearings over a beam, some two degrees apart."""
    steps = round(half_width / _FACET_SPACING)
    return np.asarray(np.arange(-steps, steps + 1) * (half_width / steps), dtype=np.float64)


def farthest(heard: Callable[[float], bool], reach: float) -> float:
    """The last range, m, up to `reach`, at which something is heard; by bisection."""
    low, high = 0.0, reach
    if heard(high):
        return high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if heard(middle):
            low = middle
        else:
            high = middle
    return high
