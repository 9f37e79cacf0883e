"""A baseline to compare with: how the range layer of the nav2 navigation stack models a sonar.

Written from a description of nav2_costmap_2d's RangeSensorLayer, to measure what it costs to do as it does;
no map of a robot is made with it. What it does, with its defaults:

- lambda = (1 - (1 + tanh 2(r - phi_v))/2) (1 - (alpha/beta)^2) says how much a ping is believed; with phi_v =
  1.2 m that is 0.69 on the axis at 1 m, 0.039 at 2 m, 0.0007 at 3 m: what lies beyond is neither marked nor
  cleared, but for the cell on the axis, which is set to 233 of 254 whatever was known.
- The band of an echo is +-resolution s: the size of a cell, taken as a part of the range (20 cm at 4 m for
  cells of 5 cm).
- Probabilities are bytes, 0...254, cut off, not rounded; 0 never rises again but by way of that one cell.
- The box around a cone a fifth longer than the reading is gone through. An echo is neutral outside the cone;
  but `clear_on_max_reading` (off by default) makes 0 of the whole box, and of what others have seen there.
- Without that, silence is dropped. Nothing fades.
"""

from dataclasses import dataclass
from math import cos, sin
from typing import Self

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.cone import Floats
from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.pose import Pose
from echogrid.mapping.sounding import Sounding

LETHAL = 254
"""The byte of certainty."""
NOTHING = 255
"""What the layer says where it neither marks nor clears."""

_EVEN = LETHAL // 2
_ON_AXIS = 233
_LONGER = 1.2
"""The sides of the cone's triangle over the reading."""
_THINNEST = 1e-9
"""m: the band of a reading of 0."""


@dataclass(frozen=True, slots=True)
class RangeLayerSettings:
    """As the layer calls them, with its defaults. `inflate_cone` is its default, 1: all of the box."""

    phi: float = 1.2
    """m, phi_v: where half of a ping is believed."""
    mark_threshold: float = 0.8
    clear_threshold: float = 0.2
    clear_on_max_reading: bool = False


DEFAULTS = RangeLayerSettings()


def trust(distance: Floats, bearing: Floats, half_angle: float, phi: float) -> Floats:
    """lambda, 0...1."""
    near = 1.0 - (1.0 + np.tanh(2.0 * (distance - phi))) / 2.0
    central = np.maximum(1.0 - (bearing / half_angle) ** 2, 0.0)
    result: Floats = near * central
    return result


def sensed(distance: Floats, echo: float, band: float, believed: Floats) -> Floats:
    """P(Occupied) of an echo, from (1 - lambda)/2 before it to (1 + lambda)/2 at it: even at and beyond its
    far side, and falling in with a parabola one band before the near side."""
    depth = (distance - echo) / band
    before, rise, at = depth < -2.0, (depth >= -2.0) & (depth < -1.0), (depth >= -1.0) & (depth < 1.0)
    shape = np.select(
        [before, rise, at], [np.full_like(depth, -1.0), (depth + 2.0) ** 2 - 1.0, 1.0 - depth**2], 0.0
    )
    return 0.5 + 0.5 * believed * shape


class RangeLayerGrid:
    """A theory, to be judged as the others are."""

    def __init__(self, geometry: GridGeometry, settings: RangeLayerSettings = DEFAULTS) -> None:
        self.geometry = geometry
        self.bytes: NDArray[np.uint8] = np.full(geometry.shape, _EVEN, np.uint8)
        """(rows, cols) 254 P(Occupied), row 0 = south."""
        self._seen: NDArray[np.bool_] = np.zeros(geometry.shape, np.bool_)
        self._settings = settings

    def update(self, sounding: Sounding) -> Patch | None:
        """Fuse one ping; the patch that it touched, None if it said nothing."""
        if sounding.echo is None and not self._settings.clear_on_max_reading:
            return None
        reading = sounding.ranger.farthest if sounding.echo is None else sounding.echo
        patch = self._box(sounding, reading)
        self._mark(sounding.transducer.compose(Pose(reading)))
        says = self._says(sounding, reading, patch)
        prior = self.bytes[patch] / LETHAL
        posterior = says * prior / (says * prior + (1.0 - says) * (1.0 - prior))
        speaks = says != 0.5
        self.bytes[patch] = np.where(speaks, posterior * LETHAL, self.bytes[patch]).astype(np.uint8)
        self._seen[patch] |= speaks
        return patch if self._seen[patch].any() else None

    def _box(self, sounding: Sounding, reading: float) -> Patch:
        """The box over the transducer, the cone's far corners and, where a wide cone needs it, the
        reading."""
        seat, beta = sounding.transducer, sounding.ranger.half_angle
        corners = [(seat.yaw, reading)]
        corners += [(seat.yaw + side * beta, _LONGER * reading) for side in (-1.0, 1.0)]
        xs = [seat.x, *(seat.x + length * cos(yaw) for yaw, length in corners)]
        ys = [seat.y, *(seat.y + length * sin(yaw) for yaw, length in corners)]
        return self.geometry.window(min(xs), min(ys), max(xs), max(ys))

    def _mark(self, end: Pose) -> None:
        """Set the cell on the axis in which the reading ends."""
        cell = self.geometry.cell(end.x, end.y)
        if self.geometry.contains(*cell):
            self.bytes[cell], self._seen[cell] = _ON_AXIS, True

    def _says(self, sounding: Sounding, reading: float, patch: Patch) -> Floats:
        """(rows, cols) of the patch: P(Occupied) by the ping alone; 0 where it clears, 0.5 where it is
        neutral."""
        seat = sounding.transducer
        dx = self.geometry.x_centres[patch[1]][np.newaxis, :] - seat.x
        dy = self.geometry.y_centres[patch[0]][:, np.newaxis] - seat.y
        distance = np.hypot(dx, dy)
        if sounding.echo is None:
            return np.zeros_like(distance)
        c, s = cos(seat.yaw), sin(seat.yaw)
        bearing = np.arctan2(c * dy - s * dx, c * dx + s * dy)
        believed = trust(distance, bearing, sounding.ranger.half_angle, self._settings.phi)
        return sensed(distance, reading, max(self.geometry.resolution * reading, _THINNEST), believed)

    def occupancy(self) -> NDArray[np.float32]:
        """(rows, cols) P(Occupied), row 0 = south; 0.5 where unknown."""
        return np.where(self._seen, self.bytes / np.float32(LETHAL), np.float32(0.5)).astype(np.float32)

    def costs(self) -> NDArray[np.uint8]:
        """(rows, cols) what the layer tells the navigation: `LETHAL` above the mark threshold, 0 below the
        clear threshold, `NOTHING` between them."""
        marked = self.bytes > int(self._settings.mark_threshold * LETHAL)
        cleared = self.bytes < int(self._settings.clear_threshold * LETHAL)
        return np.select([marked, cleared], [LETHAL, 0], NOTHING).astype(np.uint8)

    def unknown(self) -> NDArray[np.bool_]:
        """(rows, cols) True where no ping has spoken."""
        return ~self._seen

    def copy(self) -> Self:
        """An independent twin."""
        twin = type(self)(self.geometry, self._settings)
        twin.bytes, twin._seen = self.bytes.copy(), self._seen.copy()
        return twin
