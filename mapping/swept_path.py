"""How long a robot may go on with a twist until its footprint touches something.

Exact for straight ways, arcs and turns on the spot: seen from the robot a point of the world moves on a
straight line, or on a circle around the robot's centre of rotation, which stands still there. The first
crossing of that with the outline, widened by a radius, is the touch. The widened outline is bounded by its
sides moved outwards and by circles around its corners.
"""

from math import asin, copysign, cos, hypot, inf, pi, sin, tau

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.footprint import Floats, Footprint
from echogrid.mapping.twist import Twist

_STRAIGHT = 1e5
"""m: a curve of a larger radius is straight; over 25 m it is 3 mm off."""
_TOUCH = 1e-6
"""m: what is nearer to the outline than this lies within it."""
_NEARLY = 1.0 - 1e-12
"""Of the highest square of a speed: less is surely not it, however it was rounded."""


def fastest(footprint: Footprint, twist: Twist) -> float:
    """m/s of the corner that moves fastest; no other point of the footprint is faster."""
    if not twist.turn_rate:
        return abs(twist.speed)
    ahead, aside = twist.speed - twist.turn_rate * footprint.y, twist.turn_rate * footprint.x
    squares = ahead * ahead + aside * aside
    (first,) = (squares >= squares.max() * _NEARLY).nonzero()
    return max(hypot(ahead.item(corner), aside.item(corner)) for corner in first.tolist())


def touches(
    footprint: Footprint, twist: Twist, x: Floats, y: Floats, radius: float, within: float = inf
) -> Floats:
    """(n,) s until the footprint touches discs of that radius (m) around points (n,) of base_link; or inf.

    A disc that it touches already counts when it would come nearer than it is. A point within the footprint
    is the robot's own place, and is never touched. What is touched later than `within` may be inf, too.
    """
    result = np.full(len(x), inf)
    chosen = _candidates(footprint, twist, (x, y), radius, within)
    x, y = x.take(chosen), y.take(chosen)
    radii = np.full(len(chosen), radius)
    (near,) = (np.hypot(x, y) <= footprint.reach + radius + 2.0 * _TOUCH).nonzero()
    if len(near):
        radii[near] = np.minimum(radius, footprint.distance(x.take(near), y.take(near)) - _TOUCH)
        (outside,) = (radii > 0.0).nonzero()
        chosen, x, y, radii = chosen.take(outside), x.take(outside), y.take(outside), radii.take(outside)
    if len(chosen):
        way = _straight if _is_straight(twist) else _arc
        result[chosen] = way(footprint, twist, (x, y), radii)
    return result


def sweeps(footprint: Footprint, twist: Twist, x: Floats, y: Floats, within: float = inf) -> Floats:
    """(n,) s until the footprint comes over points (n,) of base_link, which lie outside of it; or inf.

    What it comes over later than `within` may be inf, too.
    """
    result = np.full(len(x), inf)
    chosen = _candidates(footprint, twist, (x, y), 0.0, within)
    if len(chosen):
        way = _straight if _is_straight(twist) else _arc
        result[chosen] = way(footprint, twist, (x.take(chosen), y.take(chosen)), None)
    return result


def _is_straight(twist: Twist) -> bool:
    return abs(twist.speed) >= _STRAIGHT * abs(twist.turn_rate)


def _candidates(
    footprint: Footprint, twist: Twist, points: tuple[Floats, Floats], radius: float, within: float
) -> NDArray[np.intp]:
    """Which points the disc around the footprint, wider by a radius, may come over in that time, or more."""
    if twist.stands:
        return np.zeros(0, np.intp)
    x, y = points
    room = footprint.reach + radius + _TOUCH
    if _is_straight(twist):
        beside = (y >= footprint.y.min() - radius) & (y <= footprint.y.max() + radius)
        ahead = x if twist.speed > 0.0 else -x
        beside &= (ahead >= -room) & (ahead <= abs(twist.speed) * within + room)
        return np.flatnonzero(beside)
    centre = twist.speed / twist.turn_rate
    up = y - centre
    away = np.hypot(x, up)
    inside = (away >= abs(centre) - room) & (away <= abs(centre) + room)
    # From the centre of rotation the disc is seen so far to either side of base_link, which turns by so much.
    aside = asin(room / abs(centre)) if room < abs(centre) else pi
    turn = min(abs(twist.turn_rate) * within, tau)
    half = 0.5 * turn + aside + _TOUCH
    if half < pi:
        middle = copysign(0.5 * pi, -centre) + copysign(0.5 * turn, twist.turn_rate)
        inside &= cos(middle) * x + sin(middle) * up >= cos(half) * away
    return np.flatnonzero(inside)


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
        way = (across - _moved(footprint, radius)) / against
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
    far, turns = away.take(point), np.full(len(away), inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        middle = off.take(side) + _moved(footprint, None if radius is None else radius.take(point))
        chord = np.sqrt((far - middle) * (far + middle))
        begins, length = start.take(side), footprint.length.take(side)
        for half in (chord, -chord):
            at = half - begins
            (met,) = ((at >= 0.0) & (at <= length)).nonzero()
            direction = normal.take(side.take(met)) + np.arctan2(half.take(met), middle.take(met))
            _meet(turns, sense, (point.take(met), angle), direction)
        if radius is not None:
            corner, bearing = np.hypot(cx, cy).take(side), np.arctan2(cy, cx).take(side)
            disc = radius.take(point)
            square = (disc - (far - corner)) * (disc + (far - corner)) / (4.0 * far * corner)
            root = np.sqrt(square)
            (met,) = (root <= 1.0).nonzero()
            spread, bearing = 2.0 * np.arcsin(root.take(met)), bearing.take(met)
            for half in (spread, -spread):
                _meet(turns, sense, (point.take(met), angle), bearing + half)
    return turns / abs(twist.turn_rate)


def _meet(turns: Floats, sense: float, seen: tuple[NDArray[np.intp], Floats], direction: Floats) -> None:
    """Points, by their numbers and the angles of all, turn until they are seen in a direction."""
    points, angle = seen
    np.minimum.at(turns, points, sense * (direction - angle.take(points)) % tau)


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


def _moved(footprint: Footprint, radius: Floats | None) -> Floats | float:
    """How far a side of the outline is moved out. What is outside meets nothing that was moved in."""
    return 0.0 if radius is None else footprint.outward * radius


def _soonest(before: Floats, candidates: Floats, valid: NDArray[np.bool_]) -> Floats:
    """(n,) The least of what is known (n,) and of valid candidates (k, n) that lie ahead."""
    ahead = valid & (candidates >= 0.0)
    result: Floats = np.minimum(before, np.where(ahead, candidates, inf).min(axis=0))
    return result
