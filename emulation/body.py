"""The outline of a robot, and how far what stands around is from it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import cos, hypot, sin
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.reflectors import Pose
from echogrid.emulation.vista import Post
from echogrid.emulation.world import World

FloatArray = NDArray[np.float64]


class Gaps(NamedTuple):
    """How far things are from a robot, m; walls that it overlaps are at 0, round things below it."""

    walls: FloatArray
    """(n,)"""
    posts: FloatArray
    """(m,) Of what is round, people last."""

    @property
    def least(self) -> float:
        """The nearest of all."""
        return float(min(self.walls.min(initial=np.inf), self.posts.min(initial=np.inf)))


class Body(Protocol):
    """An outline around base_link."""

    @property
    def reach(self) -> float:
        """m: how far its farthest point is from base_link."""
        ...

    def gaps(self, pose: Pose, world: World, people: Sequence[Post]) -> Gaps:
        """How far everything is from it."""
        ...

    def speed(self, ahead: float, turn_rate: float) -> float:
        """m/s of its outline against what it may touch; m/s and rad/s of base_link."""
        ...


@dataclass(frozen=True, slots=True)
class Disc:
    """A round robot, which may turn where it stands."""

    radius: float
    """m."""

    @property
    def reach(self) -> float:
        """m."""
        return self.radius

    def speed(self, ahead: float, turn_rate: float) -> float:
        """m/s: a turn on the spot touches nothing."""
        del turn_rate
        return abs(ahead)

    def gaps(self, pose: Pose, world: World, people: Sequence[Post]) -> Gaps:
        """How far everything is from it."""
        x, y, _ = pose
        posts = _posts(world, people)
        off = np.hypot(posts[:, 0] - x, posts[:, 1] - y) - posts[:, 2]
        return Gaps(_from_point(world, x, y) - self.radius, off - self.radius)


@dataclass(frozen=True)
class Hull:
    """A convex polygon."""

    corners: tuple[tuple[float, float], ...]
    """m in base_link, counter-clockwise."""

    @cached_property
    def reach(self) -> float:
        """m."""
        return max(hypot(x, y) for x, y in self.corners)

    def speed(self, ahead: float, turn_rate: float) -> float:
        """m/s of the corner that moves fastest."""
        return max(hypot(ahead - turn_rate * y, turn_rate * x) for x, y in self.corners)

    def gaps(self, pose: Pose, world: World, people: Sequence[Post]) -> Gaps:
        """How far everything is from it."""
        x, y, yaw = pose
        axes = np.array(((cos(yaw), -sin(yaw)), (sin(yaw), cos(yaw))))
        starts = (world.starts - (x, y)) @ axes
        posts = _posts(world, people)
        return Gaps(self._of_walls(starts, world.spans @ axes), self._of_posts(posts, axes, (x, y)))

    @cached_property
    def _sides(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(k, 2) where each side begins, its direction, and (k,) its length."""
        corners = np.array(self.corners)
        spans = np.roll(corners, -1, axis=0) - corners
        lengths = np.hypot(spans[:, 0], spans[:, 1])
        return corners, spans / lengths[:, np.newaxis], lengths

    def _outside(self, points: FloatArray) -> FloatArray:
        """(n,) signed distance, m, of points (n, 2) of base_link; below 0 inside."""
        corners, along, lengths = self._sides
        off = points[:, np.newaxis, :] - corners
        reached = (off * along).sum(axis=2)
        across = off[..., 0] * along[:, 1] - off[..., 1] * along[:, 0]
        beyond = reached - np.clip(reached, 0.0, lengths)
        nearest = np.hypot(across, beyond).min(axis=1)
        return np.asarray(np.where(across.max(axis=1) <= 0.0, across.max(axis=1), nearest))

    def _of_posts(self, posts: FloatArray, axes: FloatArray, place: tuple[float, float]) -> FloatArray:
        return self._outside((posts[:, :2] - place) @ axes) - posts[:, 2]

    def _of_walls(self, starts: FloatArray, spans: FloatArray) -> FloatArray:
        """(n,) by the ends of each to the sides, and by the corners to each; 0 where they cross."""
        corners, along, _ = self._sides
        ends = np.minimum(self._outside(starts), self._outside(starts + spans))
        length = np.hypot(spans[:, 0], spans[:, 1])
        unit = spans / length[:, np.newaxis]
        off = corners[:, np.newaxis, :] - starts
        reached = (off * unit).sum(axis=2)
        across = off[..., 0] * unit[:, 1] - off[..., 1] * unit[:, 0]
        by_corner = np.hypot(across, reached - np.clip(reached, 0.0, length)).min(axis=0)
        following = np.roll(across, -1, axis=0)
        first = _across(starts[:, np.newaxis] - corners, along)
        last = _across((starts + spans)[:, np.newaxis] - corners, along)
        crossed = ((across * following < 0.0).T & (first * last < 0.0)).any(axis=1)
        return np.asarray(np.where(crossed, 0.0, np.maximum(np.minimum(ends, by_corner), 0.0)))


def _across(off: FloatArray, along: FloatArray) -> FloatArray:
    return np.asarray(off[..., 0] * along[:, 1] - off[..., 1] * along[:, 0])


def _posts(world: World, people: Sequence[Post]) -> FloatArray:
    """(m, 3): what stands and who walks."""
    if not people:
        return world.cylinders
    return np.concatenate((world.cylinders, [post[:3] for post in people]))


def _from_point(world: World, x: float, y: float) -> FloatArray:
    """(n,) m from a point to each wall."""
    dx, dy = x - world.starts[:, 0], y - world.starts[:, 1]
    along_x, along_y = world.along[:, 0], world.along[:, 1]
    reached = dx * along_x + dy * along_y
    beyond = reached - np.minimum(np.maximum(reached, 0.0), world.lengths)
    return np.asarray(np.hypot(dx * along_y - dy * along_x, beyond))
