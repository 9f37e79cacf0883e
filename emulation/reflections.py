"""From a world and a transducer in it to the echoes that come back (first order, then one or two mirrors)."""

from collections.abc import Callable, Sequence
from math import atan2, inf
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from echogrid.emulation.acoustics import BOUNCE_LOSS, Transducer
from echogrid.emulation.detector import Detector
from echogrid.emulation.ear import ear
from echogrid.emulation.reflectors import Pose, Reflector, Station, direct, specular
from echogrid.emulation.scene import Echo, Kind
from echogrid.emulation.vista import NO_WALL, TOUCH, Point, Wall
from echogrid.emulation.world import World

_NAMES = tuple(kind.name.lower() for kind in Kind)
_DISTANCE = attrgetter("distance")
_BOUNCES = 2


class _Route(NamedTuple):
    """The sensor and its mirror images, each behind the wall that mirrors the one before."""

    stations: tuple[Station, ...]
    mirrors: tuple[Wall, ...]


class Listener:
    """A transducer somewhere in a world. Without a generator it knows neither noise nor dropout."""

    def __init__(self, world: World, transducer: Transducer, rng: np.random.Generator | None = None) -> None:
        self._moment = world.at(0.0)
        self._detector = Detector(transducer.sensitivity, rng)
        faintest = self._detector.faintest
        self._ears = [ear(transducer, faintest - BOUNCE_LOSS * bounces) for bounces in range(_BOUNCES + 1)]
        self._glimpse = self._moment.world.everything
        """What may be met from where it listens now."""

    def hear(
        self, pose: Pose, on_contact: Callable[[float], Pose] | None = None, time_s: float = 0.0
    ) -> tuple[Echo, ...]:
        """What it hears of a ping at a pose (x, y, yaw; m, rad, map frame), nearest first.

        If it moves, `on_contact` says where it is when the sound has gone so many metres: it hears from where
        it is when the sound meets the first obstacle. People stand where they are at the time of the ping.
        Sound that went by mirrors is heard only if nothing returns directly.
        """
        if self._detector.misses():
            return ()
        self._moment = self._moment.world.at(time_s)
        station, reflectors = self._first_order(pose)
        if on_contact is not None and (contact := self._first_contact(station, reflectors)) < inf:
            pose = on_contact(contact)
            station, reflectors = self._first_order(pose)
        heard = self._heard(_Route((station,), ()), reflectors) if reflectors else []
        heard = heard or self._bounced(pose)
        if not heard:
            return ()
        timed = self._detector.timed(heard, [echo.distance for echo in heard])
        return tuple(sorted(timed, key=_DISTANCE))

    def _first_order(self, pose: Pose) -> tuple[Station, list[Reflector]]:
        """What may return directly."""
        station = Station.at(pose)
        self._glimpse = self._moment.glimpse_at(*pose, self._ears[0])
        return station, direct(self._moment.world, self._glimpse, station, self._ears[0])

    def _first_contact(self, station: Station, reflectors: Sequence[Reflector]) -> float:
        """Distance, m, of the nearest direct echo without noise; inf if there is none."""
        vista, place = self._glimpse, (station.x, station.y)
        for x, y, distance, loss, _ in sorted(reflectors, key=_DISTANCE):
            if loss <= self._detector.sensitivity and vista.clear(place, (x, y)):
                return distance
        return inf

    def _bounced(self, pose: Pose) -> list[Echo]:
        """Walls and corners heard by way of the smooth walls which the axis meets; the shortest such route.

        Edges and posts are left out: what they return on such a way is lost in the clutter.
        """
        route = _Route((Station.at(pose),), ())
        turning, vista = pose[:2], self._glimpse
        for allowed in self._ears[1:]:
            _, _, ray_x, ray_y = route.stations[-1]
            distance, index = vista.cast(turning, (ray_x, ray_y))
            if index == NO_WALL or self._moment.world.rough[index]:
                break
            turning = turning[0] + distance * ray_x, turning[1] + distance * ray_y
            vista, wall = self._moment.vista_of(index), self._moment.world.everything.walls[index]
            pose = _mirrored(pose, wall)
            route = _Route((*route.stations, Station.at(pose)), (*route.mirrors, wall))
            reflectors = specular(vista, route.stations[-1], allowed)
            if reflectors and (heard := self._heard(route, reflectors)):
                return [Echo(echo.distance, echo.margin, _NAMES[Kind.BOUNCE]) for echo in heard]
        return []

    def _heard(self, route: _Route, reflectors: Sequence[Reflector]) -> list[Echo]:
        """Those reflectors which are loud enough this time and which the sound can reach on this route."""
        taken = sum(BOUNCE_LOSS + wall.softness for wall in route.mirrors)
        margins = self._detector.margins([taken + reflector.loss for reflector in reflectors])
        return [
            Echo(distance, margin, _NAMES[kind])
            for (x, y, distance, _, kind), margin in zip(reflectors, margins, strict=True)
            if margin >= 0.0 and self._open_to(route, (x, y))
        ]

    def _open_to(self, route: _Route, target: Point) -> bool:
        """Whether the sound reaches a target on the route: every leg of it is clear."""
        origin, *images = route.stations
        for image, wall in zip(images[::-1], route.mirrors[::-1], strict=True):
            turning = _crossing(wall, image[:2], target)
            if turning is None or not self._moment.vista_of(wall.number).clear(turning, target):
                return False
            target = turning
        return self._glimpse.clear(origin[:2], target)


def echoes(
    world: World, pose: Pose, transducer: Transducer, rng: np.random.Generator | None = None
) -> tuple[Echo, ...]:
    """What a transducer that stands still hears at the beginning of the world."""
    return Listener(world, transducer, rng).hear(pose)


def _mirrored(pose: Pose, wall: Wall) -> Pose:
    """The image of a pose behind a wall."""
    x, y, yaw = pose
    _, nx, ny, offset, *_ = wall
    height = x * nx + y * ny - offset
    return x - 2.0 * height * nx, y - 2.0 * height * ny, 2.0 * atan2(-nx, ny) - yaw


def _crossing(wall: Wall, image: Point, target: Point) -> Point | None:
    """Where the way from an image to a target passes the wall of this image, if it does."""
    (x, y), (to_x, to_y) = image, target
    _, normal_x, normal_y, offset, along_x, along_y, first_reached, length, _ = wall
    behind = x * normal_x + y * normal_y - offset
    before = to_x * normal_x + to_y * normal_y - offset
    if behind * before >= -TOUCH * abs(behind):
        return None
    share = behind / (behind - before)
    x, y = x + share * (to_x - x), y + share * (to_y - y)
    return (x, y) if 0.0 <= x * along_x + y * along_y - first_reached <= length else None
