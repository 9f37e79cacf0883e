"""From a world and a transducer in it to the echoes that come back (first order, then one or two mirrors)."""

from collections.abc import Sequence
from math import cos, pi, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.acoustics import (
    BOUNCE_LOSS,
    Transducer,
    beam_loss,
    cylinder_loss,
    edge_loss,
    rough_loss,
)
from echogrid.emulation.notches import Notches
from echogrid.emulation.scene import Echo
from echogrid.emulation.world import NO_WALL, TOUCH, World

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]
Pose = tuple[float, float, float]

_KINDS = ("wall", "corner", "edge", "cylinder", "rough", "bounce")
_WALL, _CORNER, _EDGE, _CYLINDER, _ROUGH, _BOUNCE = range(len(_KINDS))

_LEVEL_NOISE = 2.0
"""dB, standard deviation."""
_RANGE_NOISE = 0.005
"""m, standard deviation, and in proportion to the range:"""
_RANGE_NOISE_RATIO = 0.01
_LATE_AT_THRESHOLD = 0.02
"""m: a faint echo crosses the threshold late, this much when it just does."""
_DROPOUT = 0.02
_FACET_SPACING = pi / 90.0
_BOUNCES = 2


class _Reflectors(NamedTuple):
    """Points that return sound, without regard to the beam and to what stands in between."""

    points: FloatArray
    """(k, 2) m, map frame."""
    losses: FloatArray
    """(k,) dB against a wall at the same distance; inf where nothing comes back to this place."""
    kinds: IntArray


_NOTHING = _Reflectors(np.empty((0, 2)), np.empty(0), np.empty(0, dtype=np.intp))


class _Route(NamedTuple):
    """The sensor and its mirror images, each behind the wall that mirrors the one before."""

    stations: tuple[Pose, ...]
    mirrors: tuple[int, ...]


class _Returns(NamedTuple):
    """The echoes of one route."""

    distances: FloatArray
    """(k,) m."""
    margins: FloatArray
    """(k,) dB."""
    kinds: IntArray


def echoes(
    world: World, pose: Pose, transducer: Transducer, rng: np.random.Generator | None = None
) -> tuple[Echo, ...]:
    """What a transducer at a pose (x, y, yaw; m, rad, map frame) hears, nearest first.

    Sound that went by mirrors is heard only if nothing returns directly. Without a generator there is neither
    noise nor dropout.
    """
    if rng is not None and rng.random() < _DROPOUT:
        return ()
    returns = _direct(world, pose, transducer, rng)
    if not len(returns.distances):
        returns = _bounced(world, pose, transducer, rng)
    distances = returns.distances if rng is None else _measured(returns, rng)
    return tuple(
        Echo(float(distances[i]), float(returns.margins[i]), _KINDS[returns.kinds[i]])
        for i in np.argsort(distances)
    )


def first_contact(world: World, pose: Pose, transducer: Transducer) -> float:
    """Distance, m, of the nearest direct echo without noise; inf if there is none."""
    return float(_direct(world, pose, transducer, None).distances.min(initial=np.inf))


def _measured(returns: _Returns, rng: np.random.Generator) -> FloatArray:
    """The distances with the noise of the detector."""
    distances, margins, _ = returns
    spread = _RANGE_NOISE + _RANGE_NOISE_RATIO * distances
    late = _LATE_AT_THRESHOLD * 10.0 ** (-margins / 20.0)
    return np.maximum(distances + spread * rng.standard_normal(len(distances)) + late, 0.0)


def _direct(world: World, pose: Pose, transducer: Transducer, rng: np.random.Generator | None) -> _Returns:
    """First-order echoes."""
    place = np.array(pose[:2])
    parts = [_planes(world, place), _joints(world.notches, place), _cylinders(world, place)]
    if len(world.scattering):
        parts.append(_facets(world, pose, transducer.beam_half_width))
    return _heard(world, _Route((pose,), ()), _joined(parts), transducer, rng)


def _bounced(world: World, pose: Pose, transducer: Transducer, rng: np.random.Generator | None) -> _Returns:
    """Walls and corners heard by way of the smooth walls which the axis meets; the shortest such route.

    Edges and posts are left out: what they return on such a way is lost in the clutter.
    """
    route = _Route((pose,), ())
    turning = np.array(pose[:2])
    heard = _Returns(np.empty(0), np.empty(0), np.empty(0, dtype=np.intp))
    for _ in range(_BOUNCES):
        yaw = route.stations[-1][2]
        ray = np.array((cos(yaw), sin(yaw)))
        distance, wall = world.cast(turning, ray)
        if wall == NO_WALL or world.rough[wall]:
            break
        turning = turning + distance * ray
        image = _mirrored(world, route.stations[-1], wall)
        route = _Route((*route.stations, image), (*route.mirrors, wall))
        place = np.array(image[:2])
        reflectors = _joined([_planes(world, place), _joints(world.corners, place)])
        heard = _heard(world, route, reflectors, transducer, rng)
        if len(heard.distances):
            break
    return heard._replace(kinds=np.full_like(heard.kinds, _BOUNCE))


def _mirrored(world: World, pose: Pose, wall: int) -> Pose:
    """The image of a pose behind a wall."""
    x, y, yaw = pose
    nx, ny = world.normals[wall]
    height = x * nx + y * ny - world.offsets[wall]
    wall_heading = np.arctan2(-nx, ny)
    return float(x - 2.0 * height * nx), float(y - 2.0 * height * ny), float(2.0 * wall_heading - yaw)


def _joined(parts: Sequence[_Reflectors]) -> _Reflectors:
    """One list of reflectors out of several."""
    points, losses, kinds = zip(*parts, strict=True)
    return _Reflectors(np.concatenate(points), np.concatenate(losses), np.concatenate(kinds))


def _planes(world: World, place: FloatArray) -> _Reflectors:
    """A smooth wall answers from the foot of the perpendicular, if that lies on it."""
    reached = world.along @ place - world.first_reached
    answering = np.flatnonzero((reached >= 0.0) & (reached <= world.lengths) & ~world.rough)
    normals = world.normals[answering]
    height = normals @ place - world.offsets[answering]
    points = place - height[:, np.newaxis] * normals
    return _Reflectors(points, np.zeros(len(points)), np.full(len(points), _WALL))


def _joints(notches: Notches, place: FloatArray) -> _Reflectors:
    """A concave corner returns what comes from within it; an edge or a free end diffracts a little."""
    offset = place - notches.points
    distances = np.hypot(offset[:, 0], offset[:, 1])
    facing = (offset * notches.middle).sum(axis=1) > notches.cosine * distances
    corner = notches.corner[facing]
    losses = np.where(corner, 0.0, edge_loss(np.maximum(distances[facing], TOUCH)))
    return _Reflectors(notches.points[facing], losses, np.where(corner, _CORNER, _EDGE))


def _cylinders(world: World, place: FloatArray) -> _Reflectors:
    """A cylinder answers from its nearest point."""
    centres, radii = world.cylinders[:, :2], world.cylinders[:, 2]
    offset = place - centres
    distances = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), radii)
    points = centres + (radii / distances)[:, np.newaxis] * offset
    return _Reflectors(points, cylinder_loss(distances - radii, radii), np.full(len(points), _CYLINDER))


def _facets(world: World, pose: Pose, half_width: float) -> _Reflectors:
    """Rough walls scatter from wherever the beam falls on them: a fan of rays samples them."""
    origin = np.array(pose[:2])
    in_fan = world.scattering[_in_fan(world.walls[world.scattering], pose, half_width)]
    if not len(in_fan):
        return _NOTHING
    steps = round(half_width / _FACET_SPACING)
    headings = pose[2] + np.arange(-steps, steps + 1) * (half_width / steps)
    rays = np.array((np.cos(headings), np.sin(headings))).T
    distances = world.cast_on_walls(origin, rays, in_fan)
    nearest = distances.argmin(axis=1)
    distance = distances[np.arange(len(rays)), nearest]
    struck = np.flatnonzero(distance < np.inf)
    rays, walls = rays[struck], in_fan[nearest[struck]]
    cosines = np.maximum(np.abs((rays * world.normals[walls]).sum(axis=1)), TOUCH)
    points = origin + distance[struck, np.newaxis] * rays
    return _Reflectors(points, rough_loss(cosines), np.full(len(points), _ROUGH))


def _in_fan(walls: FloatArray, pose: Pose, half_width: float) -> BoolArray:
    """Which walls (k, 4) may reach into a fan about the axis: not wholly to one side of it."""
    x, y, yaw = pose
    left, right = yaw + half_width, yaw - half_width
    inwards = np.array(((sin(left), -sin(right)), (-cos(left), cos(right))))
    ends = walls.reshape(-1, 2, 2) - (x, y)
    return np.asarray((ends @ inwards >= 0.0).any(axis=1).all(axis=1))


def _heard(
    world: World,
    route: _Route,
    reflectors: _Reflectors,
    transducer: Transducer,
    rng: np.random.Generator | None,
) -> _Returns:
    """Those reflectors which are loud enough and which the sound can reach on this route."""
    distances, losses = _received(route.stations[-1], reflectors, transducer)
    losses = losses + BOUNCE_LOSS * len(route.mirrors)
    if rng is not None:
        losses += _LEVEL_NOISE * rng.standard_normal(len(losses))
    margins = transducer.sensitivity - losses
    loud = (margins >= 0.0) & (distances >= transducer.blanking) & (distances <= transducer.reach)
    chosen = np.flatnonzero(loud)
    chosen = chosen[_open_to(world, route, reflectors.points[chosen])]
    return _Returns(distances[chosen], margins[chosen], reflectors.kinds[chosen])


def _received(pose: Pose, reflectors: _Reflectors, transducer: Transducer) -> tuple[FloatArray, FloatArray]:
    """Distances, m, and losses, dB, of the reflectors in the beam of a transducer at a pose."""
    x, y, yaw = pose
    dx, dy = reflectors.points[:, 0] - x, reflectors.points[:, 1] - y
    ahead, aside = dx * cos(yaw) + dy * sin(yaw), dy * cos(yaw) - dx * sin(yaw)
    distances = np.hypot(dx, dy)
    off_axis = beam_loss(np.arctan2(aside, ahead), transducer.null_angle)
    return distances, reflectors.losses + off_axis + transducer.range_loss(distances)


def _open_to(world: World, route: _Route, targets: FloatArray) -> IntArray:
    """Which of the targets (k, 2) the sound reaches on the route, as indices: every leg is clear."""
    reached = np.arange(len(targets))
    corners = [targets]
    for image, wall in zip(route.stations[:0:-1], route.mirrors[::-1], strict=True):
        turning, on_wall = _crossing(world, np.array(image[:2]), corners[-1], wall)
        reached = reached[on_wall]
        corners = [points[on_wall] for points in (*corners, turning)]
    if not len(reached):
        return reached
    origin = np.full_like(corners[-1], route.stations[0][:2])
    starts, ends = np.concatenate((*corners[1:], origin)), np.concatenate(corners)
    clear = world.line_of_sight(starts, ends).reshape(len(corners), -1).all(axis=0)
    return np.asarray(reached[clear])


def _crossing(
    world: World, image: FloatArray, targets: FloatArray, wall: int
) -> tuple[FloatArray, BoolArray]:
    """Where the ways from an image (2,) to targets (k, 2) pass the wall of this image, and if they do."""
    normal, offset = world.normals[wall], world.offsets[wall]
    behind = float(image @ normal - offset)
    before = targets @ normal - offset
    through = behind * before < -TOUCH * abs(behind)
    share = behind / np.where(through, behind - before, 1.0)
    points = image + share[:, np.newaxis] * (targets - image)
    reached = (points - world.starts[wall]) @ world.along[wall]
    return points, through & (reached >= 0.0) & (reached <= world.lengths[wall])
