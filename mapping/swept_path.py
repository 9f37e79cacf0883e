"""How long a robot may go on with a twist until its footprint touches something.

Exact for straight ways, arcs and turns on the spot: seen from the robot a point of the world moves on a
straight line, or on a circle around the robot's centre of rotation, which stands still there. The first
crossing of that with the outline, widened by a radius, is the touch. The widened outline is bounded by its
sides moved outwards and by circles around its corners.
"""

from functools import lru_cache
from math import hypot, inf, tau

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.footprint import Floats, Footprint
from echogrid.mapping.twist import Twist

_STRAIGHT = 1e5
"""m: a curve of a larger radius is straight; over 25 m it is 3 mm off."""
_TOUCH = 1e-6
"""m: what is nearer to the outline than this lies within it."""


def fastest(footprint: Footprint, twist: Twist) -> float:
    """m/s of the corner that moves fastest; no other point of the footprint is faster."""
    corners = footprint.corners
    return max(hypot(twist.speed - twist.turn_rate * y, twist.turn_rate * x) for x, y in corners)


def touches(footprint: Footprint, twist: Twist, x: Floats, y: Floats, radius: float) -> Floats:
    """(n,) s until the footprint touches discs of that radius (m) around points (n,) of base_link; or inf.

    A disc that it touches already counts when it would come nearer than it is. A point within the footprint
    is the robot's own place, and is never touched.
    """
    result = np.full(len(x), inf)
    chosen = np.flatnonzero(_in_band(footprint, twist, x, y, radius))
    gap = footprint.distance(x[chosen], y[chosen])
    outside = gap > _TOUCH
    chosen, radii = chosen[outside], np.minimum(radius, gap[outside] - _TOUCH)
    if len(chosen):
        way = _straight if _is_straight(twist) else _arc
        result[chosen] = way(footprint, twist, (x[chosen], y[chosen]), radii)
    return result


def sweeps(footprint: Footprint, twist: Twist, x: Floats, y: Floats) -> Floats:
    """(n,) s until the footprint comes over points (n,) of base_link, which lie outside of it; or inf."""
    result = np.full(len(x), inf)
    chosen = np.flatnonzero(_in_band(footprint, twist, x, y, 0.0))
    way = _straight if _is_straight(twist) else _arc
    result[chosen] = way(footprint, twist, (x[chosen], y[chosen]), None)
    return result


def _is_straight(twist: Twist) -> bool:
    return abs(twist.speed) >= _STRAIGHT * abs(twist.turn_rate)


def _in_band(footprint: Footprint, twist: Twist, x: Floats, y: Floats, radius: float) -> NDArray[np.bool_]:
    """(n,) Whether the footprint may come to a point at all."""
    if twist.stands:
        return np.zeros(len(x), np.bool_)
    if _is_straight(twist):
        beside: NDArray[np.bool_] = (y >= footprint.y.min() - radius) & (y <= footprint.y.max() + radius)
        return beside
    centre = twist.speed / twist.turn_rate
    away = np.hypot(x, y - centre)
    nearest, farthest = _ring(footprint, centre)
    inside: NDArray[np.bool_] = (away >= nearest - radius) & (away <= farthest + radius)
    return inside


@lru_cache(maxsize=16)
def _ring(footprint: Footprint, centre: float) -> tuple[float, float]:
    """m from a centre of rotation, (0, centre), to the nearest and the farthest of the footprint."""
    farthest = np.hypot(footprint.x, footprint.y - centre).max()
    return float(footprint.distance(np.zeros(1), np.array([centre]))[0]), float(farthest)


def _straight(
    footprint: Footprint, twist: Twist, points: tuple[Floats, Floats], radius: Floats | None
) -> Floats:
    """Points move against the robot's own direction. Without a radius they are no discs."""
    forward = 1.0 if twist.speed > 0.0 else -1.0
    ex, ey = (each[:, np.newaxis] for each in footprint.along)
    px, py = points[0] - footprint.x[:, np.newaxis], points[1] - footprint.y[:, np.newaxis]
    across, against = px * ey - py * ex, forward * ey
    ways = np.full(len(points[0]), inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for side in _sides(radius):
            way = (across - side) / against
            at = (px - way * forward) * ex + py * ey
            ways = _soonest(ways, way, (at >= 0.0) & (at <= footprint.length[:, np.newaxis]))
        if radius is not None:
            way = px * forward - np.sqrt(radius**2 - py**2)
            ways = _soonest(ways, way, np.abs(py) <= radius)
    return ways / abs(twist.speed)


def _arc(footprint: Footprint, twist: Twist, points: tuple[Floats, Floats], radius: Floats | None) -> Floats:
    """Points turn around the centre of rotation, (0, speed / turn rate), against the robot's own turn.

    Chords are written as products of differences: on wide arcs the squares would cancel.
    """
    centre, sense = twist.speed / twist.turn_rate, -1.0 if twist.turn_rate > 0.0 else 1.0
    x, y = points[0], points[1] - centre
    away, angle = np.hypot(x, y), np.arctan2(y, x)
    ex, ey = footprint.along
    cx, cy = footprint.x, footprint.y - centre
    off, start, normal = cx * ey - cy * ex, cx * ex + cy * ey, np.arctan2(-ex, ey)
    side, point = _pairs(away, off, (start, start + footprint.length), 0.0 if radius is None else radius)
    far, turns = away[point], np.full(len(away), inf)

    def meet(met: NDArray[np.bool_], direction: Floats) -> None:
        """Points of pairs turn until they are seen in a direction."""
        points = point[met]
        np.minimum.at(turns, points, sense * (direction - angle[points]) % tau)

    with np.errstate(divide="ignore", invalid="ignore"):
        for out in (0.0,) if radius is None else (radius[point], -radius[point]):
            middle = off[side] + out
            chord = np.sqrt((far - middle) * (far + middle))
            for half in (chord, -chord):
                at = half - start[side]
                met = (at >= 0.0) & (at <= footprint.length[side])
                meet(met, normal[side[met]] + np.arctan2(half[met], middle[met]))
        if radius is not None:
            corner, bearing, disc = np.hypot(cx, cy)[side], np.arctan2(cy, cx)[side], radius[point]
            square = (disc - (far - corner)) * (disc + (far - corner)) / (4.0 * far * corner)
            root = np.sqrt(square)
            met = root <= 1.0
            spread = 2.0 * np.arcsin(root[met])
            for half in (spread, -spread):
                meet(met, bearing[met] + half)
    return turns / abs(twist.turn_rate)


def _pairs(
    away: Floats, off: Floats, ends: tuple[Floats, Floats], radius: Floats | float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """(m,) sides and points which are as far from the centre of rotation as they must be to meet.

    They are few of all pairs. `off` is how far each side's line passes from the centre, `ends` are those of
    the side on it.
    """
    start, end = ends
    nearest = np.hypot(off, np.minimum(np.maximum(start, 0.0), end))
    farthest = np.hypot(off, np.maximum(np.abs(start), np.abs(end)))
    room = radius + _TOUCH  # for rounding
    pairs = (away + room >= nearest[:, np.newaxis]) & (away - room <= farthest[:, np.newaxis])
    side, point = pairs.nonzero()
    return side, point


def _sides(radius: Floats | None) -> tuple[Floats | float, ...]:
    """How far a side of the outline is moved out, and in."""
    return (0.0,) if radius is None else (radius, -radius)


def _soonest(before: Floats, candidates: Floats, valid: NDArray[np.bool_]) -> Floats:
    """(n,) The least of what is known (n,) and of valid candidates (k, n) that lie ahead."""
    ahead = valid & (candidates >= 0.0)
    result: Floats = np.minimum(before, np.where(ahead, candidates, inf).min(axis=0))
    return result
