"""What the pings have said of each cell, as a few whole numbers: enough to tell how sure one can be of it.

A wall that was seen a hundred times from one spot is not a hundred times as sure. So beside the sums of what
was heard there stand: from how many directions, how near the axis and how near the transducer at best, and
what of each echo a cell can claim, for an echo comes from one place on its arc, not from all of it; and from
where it came, for a wall answers at right angles.
"""

from collections import OrderedDict
from math import floor, pi, radians
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.cone import Cone, Floats, cast
from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.sounding import Sounding

MILLI = 1000.0
"""All but the directions are kept in thousandths."""
AXIS = radians(8.0)
"""A cell counts by exp(-2 (alpha/8 deg)^2)."""
NEAREST = 0.3
"""m: and by 1/r, but not more than at this distance."""
SILENCE_REACH = 3.0
"""m: what does not answer from further away says nothing."""
DIRECTIONS = 24
"""Into so many the circle is cut."""
NORMALS = 8
"""Into so many half the circle is cut: the directions, there or back, in which a wall may answer."""

_PRIOR_HIT, _PRIOR_MISS, _NOBODY = 0.05, 0.15, 0.02
"""A cell's claim to an echo is w (hit + .05)/(hit + miss + .2); of each echo .02 claims are nobody's."""
_PLACE, _TURN, _RANGE = 0.1, radians(7.5), 0.1
"""m, rad and m: pings that are alike to within that say the same."""
_REMEMBERED = 4096


class Statistics(NamedTuple):
    """(rows, cols) each but for the share, row 0 = south."""

    hit: NDArray[np.int32]
    """Weights of the echoes in whose region I the cell lay, milli."""
    miss: NDArray[np.int32]
    """Weights of those in whose region II it lay."""
    silent: NDArray[np.int32]
    """Weights of pings without an echo in whose cone it lay, and near."""
    share: NDArray[np.int32]
    """(8, rows, cols) what of the echoes it can claim, milli echoes: of those that came along the x axis
    (within 11.25 deg, there or back), of those along an axis 22.5 deg to the left of it, and so on."""
    best: NDArray[np.int32]
    """The highest weight off the axis of a hit, milli."""
    nearest: NDArray[np.int32]
    """mm: from where it was hit at the nearest; 0: never."""
    clearest: NDArray[np.int32]
    """The highest weight of a miss, milli."""
    hit_from: NDArray[np.uint32]
    """A bit for each direction from which it was hit,"""
    missed_from: NDArray[np.uint32]
    """and missed, near the axis."""


class CellEvidence:
    """Kept online. A ping which is like an earlier one of the same ranger adds nothing."""

    def __init__(self, geometry: GridGeometry) -> None:
        self.geometry = geometry
        kinds = (np.int32,) * 7 + (np.uint32,) * 2
        blank = Statistics._make(np.zeros(geometry.shape, kind) for kind in kinds)
        self.statistics = blank._replace(share=np.zeros((NORMALS, *geometry.shape), np.int32))
        self._known: OrderedDict[tuple[str, int, int, int, int], None] = OrderedDict()

    def add(self, sounding: Sounding) -> Patch | None:
        """Take a ping; the patch of which it speaks, None if that holds no cell."""
        cone = cast(self.geometry, sounding)
        if not len(cone.rows):
            return None
        if self._is_new(sounding):
            weights = np.exp(-2.0 * (cone.bearing / AXIS) ** 2)
            near = weights / np.maximum(cone.distance, NEAREST)
            if cone.echo:
                self._heard(cone, sounding, weights, near)
            else:
                self._silence(cone, near)
        return cone.patch

    def copy(self) -> "CellEvidence":
        """An independent twin."""
        twin = CellEvidence(self.geometry)
        twin.statistics = Statistics._make(each.copy() for each in self.statistics)
        twin._known = self._known.copy()
        return twin

    def _is_new(self, sounding: Sounding) -> bool:
        seat = sounding.transducer
        key = (
            sounding.ranger.name,
            floor(seat.x / _PLACE),
            floor(seat.y / _PLACE),
            floor(seat.yaw / _TURN),
            -1 if sounding.echo is None else floor(sounding.echo / _RANGE),
        )
        new = key not in self._known
        self._known[key] = None
        self._known.move_to_end(key)
        if len(self._known) > _REMEMBERED:
            self._known.popitem(last=False)
        return new

    def _heard(self, cone: Cone, sounding: Sounding, weights: Floats, near: Floats) -> None:
        s = self.statistics
        on, off = np.nonzero(cone.occupied)[0], np.nonzero(~cone.occupied)[0]
        angles = self._angles(cone, sounding)
        directions = _bits(angles)
        at = cone.rows[off], cone.cols[off]
        s.miss[at] += _milli(near[off])
        s.clearest[at] = np.maximum(s.clearest[at], _milli(near[off]))
        central = off[cone.bearing[off] < AXIS]
        s.missed_from[cone.rows[central], cone.cols[central]] |= directions[central]
        at = cone.rows[on], cone.cols[on]
        s.hit[at] += _milli(near[on])
        s.best[at] = np.maximum(s.best[at], _milli(weights[on]))
        before, here = s.nearest[at], np.maximum(_milli(cone.distance[on]), 1)
        s.nearest[at] = np.where(before > 0, np.minimum(before, here), here)
        s.hit_from[at] |= directions[on]
        hit, miss = s.hit[at] / MILLI, s.miss[at] / MILLI
        claim = weights[on] * (hit + _PRIOR_HIT) / (hit + miss + _PRIOR_HIT + _PRIOR_MISS)
        s.share[_normals(angles[on]), *at] += _milli(shared(claim))

    def _silence(self, cone: Cone, near: Floats) -> None:
        close = cone.distance < SILENCE_REACH
        self.statistics.silent[cone.rows[close], cone.cols[close]] += _milli(near[close])

    def _angles(self, cone: Cone, sounding: Sounding) -> Floats:
        """(n,) rad, the direction in which the cell lies from the transducer."""
        dx = self.geometry.x_centres[cone.cols] - sounding.transducer.x
        dy = self.geometry.y_centres[cone.rows] - sounding.transducer.y
        angles: Floats = np.arctan2(dy, dx)
        return angles


def shared(claims: Floats) -> Floats:
    """(n,) What each cell of an arc gets of its echo; the rest to 1 is nobody's."""
    result: Floats = claims / (claims.sum() + _NOBODY)
    return result


def _bits(angles: Floats) -> NDArray[np.uint32]:
    """The bit of each direction."""
    turned = np.floor((angles / (2.0 * pi) + 0.5) * DIRECTIONS).astype(np.int64)
    result: NDArray[np.uint32] = np.left_shift(1, turned % DIRECTIONS).astype(np.uint32)
    return result


def _normals(angles: Floats) -> NDArray[np.int64]:
    """Which of the eight axes each direction is nearest to."""
    return np.floor(angles / pi * NORMALS + 0.5).astype(np.int64) % NORMALS


def _milli(values: Floats) -> NDArray[np.int32]:
    return np.rint(values * MILLI).astype(np.int32)
