"""Which points in a vista return sound to a transducer, whatever stands in between."""

from collections.abc import Iterable, Sequence
from math import atan2, cos, hypot, sin
from typing import NamedTuple

import numpy as np

from echogrid.emulation.acoustics import beam_loss, cylinder_loss, edge_loss, rough_loss
from echogrid.emulation.ear import Ear
from echogrid.emulation.scene import Kind
from echogrid.emulation.vista import TOUCH, Notch, Post, Vista, Wall
from echogrid.emulation.world import World

Pose = tuple[float, float, float]
"""x, y (m), yaw (rad), map frame."""

_WALL, _CORNER, _EDGE, _CYLINDER, _ROUGH = Kind.WALL, Kind.CORNER, Kind.EDGE, Kind.CYLINDER, Kind.ROUGH


class Station(NamedTuple):
    """A place to listen from, and the direction of the axis there; map frame, m."""

    x: float
    y: float
    ray_x: float
    ray_y: float

    @classmethod
    def at(cls, pose: Pose) -> "Station":
        """The one of a sensor at a pose."""
        x, y, yaw = pose
        return cls(x, y, cos(yaw), sin(yaw))


class Reflector(NamedTuple):
    """A point that returns sound."""

    x: float
    y: float
    distance: float
    """m."""
    loss: float
    """dB, of all but mirrors on the way."""
    kind: Kind


_Source = tuple[float, float, float, Kind]
"""x, y (m, map frame) of a point that returns sound, the loss (dB) against a wall at the same distance on the
axis, and its kind."""


def direct(world: World, vista: Vista, station: Station, ear: Ear) -> list[Reflector]:
    """All that the ear may hear from a station, by the glimpse that it has from there."""
    sources: list[_Source] = []
    # A ping has few things of a kind in its glimpse, and often none: what is not there is not asked for.
    if vista.smooth:
        _add_planes(sources, vista.smooth, station, ear.reach)
    if vista.corners:
        _add_corners(sources, vista.corners, station, ear)
    if vista.edges:
        _add_edges(sources, vista.edges, station, ear)
    if vista.posts:
        _add_posts(sources, vista.posts, station, ear.beam_slope)
    heard = _heard(sources, station, ear) if sources else []
    if not vista.rough:
        return heard
    in_fan = [wall.number for wall in vista.rough if _in_fan(wall, station, ear)]
    return heard + _facets(world, in_fan, station, ear) if in_fan else heard


def specular(vista: Vista, station: Station, ear: Ear) -> list[Reflector]:
    """The smooth walls and corners of a vista alone.

    The station may be an image behind the wall whose vista it is: all its sight lines begin on that wall.
    """
    sources: list[_Source] = []
    _add_planes(sources, vista.smooth, station, ear.reach)
    _add_corners(sources, vista.corners, station, ear)
    return _heard(sources, station, ear)


def _heard(sources: Iterable[_Source], station: Station, ear: Ear) -> list[Reflector]:
    """Those which have lost no more than the ear allows by beam and range."""
    place_x, place_y, ray_x, ray_y = station
    transducer, allowance, slope = ear.transducer, ear.allowance, ear.beam_slope
    reflectors = []
    for x, y, loss, kind in sources:
        dx, dy = x - place_x, y - place_y
        ahead, left = dx * ray_x + dy * ray_y, dy * ray_x - dx * ray_y
        if abs(left) <= slope * ahead:
            distance = hypot(ahead, left)
            if transducer.blanking <= distance <= transducer.reach:
                loss += beam_loss(atan2(left, ahead), transducer.null_angle) + ear.range_loss(distance)
                if loss <= allowance:
                    reflectors.append(Reflector(x, y, distance, loss, kind))
    return reflectors


def _add_planes(sources: list[_Source], walls: Iterable[Wall], station: Station, reach: float) -> None:
    """A smooth wall answers from the foot of the perpendicular, if that lies on it."""
    x, y, ray_x, ray_y = station
    for _, normal_x, normal_y, offset, along_x, along_y, first_reached, length, softness in walls:
        if 0.0 <= along_x * x + along_y * y - first_reached <= length:
            height = normal_x * x + normal_y * y - offset
            if abs(height) <= reach and height * (normal_x * ray_x + normal_y * ray_y) <= 0.0:
                sources.append((x - height * normal_x, y - height * normal_y, softness, _WALL))


def _add_corners(sources: list[_Source], corners: Iterable[Notch], station: Station, ear: Ear) -> None:
    """A concave corner returns what comes from within it."""
    place_x, place_y, ray_x, ray_y = station
    slope, reach = ear.beam_slope, ear.reach
    for x, y, middle_x, middle_y, cosine, softness in corners:
        dx, dy = x - place_x, y - place_y
        if abs(dy * ray_x - dx * ray_y) <= slope * (dx * ray_x + dy * ray_y):
            distance = hypot(dx, dy)
            if distance <= reach and dx * middle_x + dy * middle_y < -cosine * distance:
                sources.append((x, y, softness, _CORNER))


def _add_edges(sources: list[_Source], edges: Iterable[Notch], station: Station, ear: Ear) -> None:
    """An edge or a free end diffracts a little what meets it within its cone."""
    place_x, place_y, ray_x, ray_y = station
    slope, reach = ear.beam_slope, ear.edge_reach
    for x, y, middle_x, middle_y, cosine, softness in edges:
        dx, dy = x - place_x, y - place_y
        if abs(dy * ray_x - dx * ray_y) <= slope * (dx * ray_x + dy * ray_y):
            distance = hypot(dx, dy)
            if distance <= reach and dx * middle_x + dy * middle_y < -cosine * distance:
                sources.append((x, y, edge_loss(max(distance, TOUCH)) + softness, _EDGE))


def _add_posts(sources: list[_Source], posts: Iterable[Post], station: Station, slope: float) -> None:
    """A cylinder answers from its nearest point, which lies where its axis does: in the beam, or not."""
    place_x, place_y, ray_x, ray_y = station
    for x, y, radius, softness in posts:
        dx, dy = place_x - x, place_y - y
        if abs(dy * ray_x - dx * ray_y) <= TOUCH - slope * (dx * ray_x + dy * ray_y):
            distance = max(hypot(dx, dy), radius)
            share = radius / distance
            loss = cylinder_loss(distance - radius, radius) + softness
            sources.append((x + share * dx, y + share * dy, loss, _CYLINDER))


def _in_fan(wall: Wall, station: Station, ear: Ear) -> bool:
    """Whether a rough wall may reach into the fan: it is not wholly to one side of it, nor too far off."""
    x, y, ray_x, ray_y = station
    if abs(wall.normal_x * x + wall.normal_y * y - wall.offset) > ear.fan_reach:
        return False
    offsets = [(end_x - x, end_y - y) for end_x, end_y in wall.ends]
    aheads = [dx * ray_x + dy * ray_y for dx, dy in offsets]
    lefts = [dy * ray_x - dx * ray_y for dx, dy in offsets]
    margins = [ear.fan_slope * ahead for ahead in aheads]
    return (
        min(aheads) <= ear.fan_reach
        and any(left <= margin for left, margin in zip(lefts, margins, strict=True))
        and any(-left <= margin for left, margin in zip(lefts, margins, strict=True))
    )


def _facets(world: World, walls: Sequence[int], station: Station, ear: Ear) -> list[Reflector]:
    """Rough walls scatter from wherever the beam falls on them: a fan of rays samples them."""
    place = np.array(station[:2])
    axes = np.array(((station.ray_x, station.ray_y), (-station.ray_y, station.ray_x)))
    rays = ear.fan @ axes
    distances = world.cast_on_walls(place, rays, np.array(walls))
    nearest = distances.argmin(axis=1)
    distance = distances[np.arange(len(rays)), nearest]
    (struck,) = (distance <= ear.fan_reach).nonzero()
    rays, distance, numbers = rays[struck], distance[struck], np.array(walls)[nearest[struck]]
    cosines = np.maximum(np.abs(np.vecdot(rays, world.normals[numbers])), TOUCH)
    losses = rough_loss(cosines) + world.softness[numbers]
    losses += ear.fan_losses[struck] + ear.transducer.range_loss(distance)
    points = place + distance[:, np.newaxis] * rays
    loud = (losses <= ear.allowance) & (distance >= ear.transducer.blanking)
    table = np.column_stack((points, distance, losses))[loud].tolist()
    return [Reflector(x, y, far, loss, _ROUGH) for x, y, far, loss in table]
