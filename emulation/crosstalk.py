"""How the sound of one transducer reaches another: straight, by a mirror, or by what scatters it.

Losses are against the echo of a large smooth wall on the axis that went as far, so that a way through the air
costs nothing here. Swapped, two transducers have the same ways; at one place they have those of an echo.
"""

from collections.abc import Iterable, Iterator
from itertools import chain
from math import atan2, cos, hypot, inf, pi, remainder, sin, sqrt, tan
from typing import NamedTuple

from echogrid.emulation.acoustics import (
    ROUGH_LOSS,
    Transducer,
    cylinder_loss,
    edge_loss,
    harmonic_mean,
    one_way_beam_loss,
    rough_loss,
)
from echogrid.emulation.piston import plane_beam_half_width
from echogrid.emulation.reflectors import Station
from echogrid.emulation.vista import TOUCH, Notch, Point, Post, Wall
from echogrid.emulation.world import Moment

_HALVINGS = 16
"""Of the arc between two bearings: then the way over a post is right to a micrometre."""


class Mouth(NamedTuple):
    """A transducer at its place."""

    station: Station
    transducer: Transducer

    def towards(self, x: float, y: float) -> tuple[float, float]:
        """Distance, m, of a point, and what the beam takes there, dB; inf behind the transducer, both."""
        place_x, place_y, ray_x, ray_y = self.station
        dx, dy = x - place_x, y - place_y
        ahead = dx * ray_x + dy * ray_y
        if ahead <= 0.0:
            return inf, inf
        bearing = atan2(dy * ray_x - dx * ray_y, ahead)
        return hypot(dx, dy), one_way_beam_loss(bearing, self.transducer.null_angle)


class Way(NamedTuple):
    """How the sound goes from one transducer to the other."""

    length: float
    """m."""
    loss: float
    """dB: of both beams, and of what it meets."""
    turn: Point | None
    """Where it turns; None: nowhere."""


class _Mirror(NamedTuple):
    """A smooth wall, and where the listener is beside it."""

    wall: Wall
    height: float
    """m, signed, over the wall's line."""
    reached: float
    """m along the wall, from its beginning."""


class _Turn(NamedTuple):
    """A point which returns sound from within a cone, and the listener's end of the way there."""

    x: float
    y: float
    middle_x: float
    middle_y: float
    cosine: float
    """Of half of the cone."""
    softness: float
    distance: float
    loss: float


class Earshot:
    """All that may turn sound towards a listener at one time, found once for all that it hears then."""

    def __init__(self, moment: Moment, listener: Mouth, faintest: float) -> None:
        """Nothing counts that has lost more than `faintest`, dB."""
        self._moment = moment
        self._listener = listener
        self._faintest = faintest
        self._place = listener.station[:2]
        self._vista = moment.vista_at(*self._place)
        self._clear: dict[Point, bool] = {}
        self._mirrors = list(self._smooth())
        self._corners = list(self._audible(self._vista.corners, 0.0))
        self._edges = list(self._audible(self._vista.edges, 0.0))
        facets = chain.from_iterable(moment.world.facets(wall.number) for wall in self._vista.rough)
        self._facets = list(self._audible(facets, ROUGH_LOSS))
        self._posts = [post for post in self._vista.posts if self._may_meet_post(post)]

    def ways_from(self, source: Mouth) -> Iterator[Way]:
        """The ways from a source, whatever stands in between."""
        yield from self._straight(source)
        yield from self._mirrored(source)
        yield from self._scattered(source)
        yield from self._diffuse(source)
        for post in self._posts:
            yield from self._around(post, source)

    def is_open(self, source: Mouth, way: Way) -> bool:
        """Whether nothing stands in the way."""
        here, there = self._place, source.station[:2]
        if way.turn is None:
            return self._vista.clear(here, there)
        if way.turn not in self._clear:
            self._clear[way.turn] = self._vista.clear(here, way.turn)
        return self._clear[way.turn] and self._moment.vista_at(*there).clear(there, way.turn)

    def _smooth(self) -> Iterator[_Mirror]:
        """Those smooth walls of which the beam may meet a part: they are not wholly on one side of it."""
        x, y, ray_x, ray_y = self._listener.station
        rough = {wall.number for wall in self._vista.rough}
        for wall, barrier in zip(self._vista.walls, self._vista.barriers, strict=True):
            dx, dy = barrier.start_x - x, barrier.start_y - y
            ahead, left = dx * ray_x + dy * ray_y, dy * ray_x - dx * ray_y
            ahead_at_end = ahead + barrier.span_x * ray_x + barrier.span_y * ray_y
            if (ahead > 0.0 or ahead_at_end > 0.0) and wall.number not in rough:
                height = wall.normal_x * x + wall.normal_y * y - wall.offset
                slope = self._slope(abs(height))
                left_at_end = left + barrier.span_y * ray_x - barrier.span_x * ray_y
                limit, limit_at_end = slope * ahead, slope * ahead_at_end
                if (left <= limit or left_at_end <= limit_at_end) and (
                    -left <= limit or -left_at_end <= limit_at_end
                ):
                    yield _Mirror(wall, height, wall.along_x * x + wall.along_y * y - wall.first_reached)

    def _slope(self, distance: float) -> float:
        """Tangent of the bearing to which something at a distance, m, or farther is loud enough at best."""
        left = self._faintest - self._at_best(distance)
        return tan(min(plane_beam_half_width(self._listener.transducer.null_angle, 2.0 * left), 0.5 * pi))

    def _at_best(self, distance: float) -> float:
        """dB that is lost on the way, if the source is right there."""
        return self._listener.transducer.way_loss(max(0.5 * distance, TOUCH))

    def _may_meet_post(self, post: Post) -> bool:
        """Whether a post is not wholly outside of the beam."""
        x, y, ray_x, ray_y = self._listener.station
        dx, dy = post.x - x, post.y - y
        slope = self._slope(hypot(dx, dy) - post.radius)
        aside = abs(dy * ray_x - dx * ray_y) - slope * (dx * ray_x + dy * ray_y)
        return aside <= post.radius * hypot(1.0, slope)

    def _audible(self, notches: Iterable[Notch], least: float) -> Iterator[_Turn]:
        """Those which the listener is in the cone of, and may hear; they take `least`, dB, from the sound."""
        x, y, ray_x, ray_y = self._listener.station
        for notch in notches:
            notch_x, notch_y, middle_x, middle_y, cosine, _ = notch
            dx, dy = notch_x - x, notch_y - y
            if dx * ray_x + dy * ray_y > 0.0 and dx * middle_x + dy * middle_y < -cosine * hypot(dx, dy):
                distance, loss = self._listener.towards(notch_x, notch_y)
                if loss + least + self._at_best(distance) <= self._faintest:
                    yield _Turn(*notch, distance, loss)

    def _straight(self, source: Mouth) -> Iterator[Way]:
        """Two transducers that face each other."""
        distance, loss = source.towards(*self._place)
        loss += self._listener.towards(*source.station[:2])[1]
        if distance > TOUCH and loss < inf:
            yield Way(distance, loss, None)

    def _mirrored(self, source: Mouth) -> Iterator[Way]:
        """By a smooth wall which has both on one side: as if the source were at its image behind it."""
        x, y = source.station[:2]
        for wall, height, reached in self._mirrors:
            source_height = wall.normal_x * x + wall.normal_y * y - wall.offset
            if height * source_height > 0.0:
                source_reached = wall.along_x * x + wall.along_y * y - wall.first_reached
                share = height / (height + source_height)
                along = reached + share * (source_reached - reached)
                if 0.0 <= along <= wall.length:
                    yield from self._by(wall, along, source)

    def _by(self, wall: Wall, along: float, source: Mouth) -> Iterator[Way]:
        """By a wall, so many metres from its beginning."""
        along += wall.first_reached
        x = wall.offset * wall.normal_x + along * wall.along_x
        y = wall.offset * wall.normal_y + along * wall.along_y
        there, source_loss = source.towards(x, y)
        back, loss = self._listener.towards(x, y)
        loss += source_loss + wall.softness
        if loss < inf:
            yield Way(there + back, loss, (x, y))

    def _scattered(self, source: Mouth) -> Iterator[Way]:
        """By the vertex of a corner, or an edge."""
        for turn, there, loss in _reached(self._corners, source):
            yield Way(there + turn.distance, loss, (turn.x, turn.y))
        for turn, there, loss in _reached(self._edges, source):
            loss += edge_loss(max(harmonic_mean(there, turn.distance), TOUCH))
            yield Way(there + turn.distance, loss, (turn.x, turn.y))

    def _diffuse(self, source: Mouth) -> Iterator[Way]:
        """By a facet of a rough wall: it scatters by the cosines towards both."""
        here_x, here_y = self._place
        x, y = source.station[:2]
        for turn, there, loss in _reached(self._facets, source):
            outward = abs((here_x - turn.x) * turn.middle_x + (here_y - turn.y) * turn.middle_y)
            inward = abs((x - turn.x) * turn.middle_x + (y - turn.y) * turn.middle_y)
            loss += rough_loss(max(sqrt(inward * outward / (there * turn.distance)), TOUCH))
            yield Way(there + turn.distance, loss, (turn.x, turn.y))

    def _around(self, post: Post, source: Mouth) -> Iterator[Way]:
        """By the side of a post on which both see it at the same angle."""
        turn, cosine = _specular_point(post, source.station[:2], self._place)
        if cosine > TOUCH:
            there, source_loss = source.towards(*turn)
            back, loss = self._listener.towards(*turn)
            loss += source_loss + post.softness
            if loss < inf:
                loss += cylinder_loss(harmonic_mean(there, back), cosine * post.radius)
                yield Way(there + back, loss, turn)


def _reached(turns: Iterable[_Turn], source: Mouth) -> Iterator[tuple[_Turn, float, float]]:
    """The turns in whose cones the source is, its distance, m, and what both beams and they take, dB."""
    x, y = source.station[:2]
    for turn in turns:
        there, loss = source.towards(turn.x, turn.y)
        if loss < inf and (x - turn.x) * turn.middle_x + (y - turn.y) * turn.middle_y > turn.cosine * there:
            yield turn, there, loss + turn.loss + turn.softness


def _specular_point(post: Post, here: Point, there: Point) -> tuple[Point, float]:
    """Where a post mirrors one place to the other (Alhazen's problem), and the cosine of incidence there.

    It lies on the arc between both bearings, and the sines of incidence are equal there: by bisection.
    """
    x, y, radius, _ = post
    first = atan2(here[1] - y, here[0] - x)
    arc = remainder(atan2(there[1] - y, there[0] - x) - first, 2.0 * pi)
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        normal = first + middle * arc
        sines = _sine(post, normal, here) + _sine(post, normal, there)
        low, high = (middle, high) if sines * arc > 0.0 else (low, middle)
    normal = first + 0.5 * (low + high) * arc
    point = x + radius * cos(normal), y + radius * sin(normal)
    way_x, way_y = here[0] - point[0], here[1] - point[1]
    return point, (way_x * cos(normal) + way_y * sin(normal)) / max(hypot(way_x, way_y), TOUCH)


def _sine(post: Post, normal: float, place: Point) -> float:
    """Of the angle, counter-clockwise, from a post's normal to a place."""
    nx, ny = cos(normal), sin(normal)
    dx, dy = place[0] - post.x - post.radius * nx, place[1] - post.y - post.radius * ny
    return (dy * nx - dx * ny) / hypot(dx, dy)
