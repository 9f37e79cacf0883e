"""A floor with all that stands on it, in plain numbers."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np

from echogrid.emulation.floor_plan import FloorPlan
from echogrid.emulation.walker import Walker
from echogrid.emulation.world import World

Screen = tuple[float, float, float, float]
"""x0, y0, x1, y1 of a thin smooth wall that stands free, m."""


@dataclass(frozen=True, slots=True)
class Box:
    """A box that stands free, turned as it happens to be."""

    x: float
    y: float
    """m, of its middle."""
    length: float
    width: float
    """m."""
    turn_deg: float
    """Of its length, from the x axis."""
    rough: bool = False
    softness: float = 0.0
    """dB."""

    def walls(self) -> Iterator[tuple[float, float, float, float]]:
        """Its four sides."""
        turn = radians(self.turn_deg)
        halves = ((1, 1), (-1, 1), (-1, -1), (1, -1))
        offsets = [(0.5 * self.length * right, 0.5 * self.width * up) for right, up in halves]
        corners = [
            (self.x + ahead * cos(turn) - left * sin(turn), self.y + ahead * sin(turn) + left * cos(turn))
            for ahead, left in offsets
        ]
        for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
            yield (*start, *end)


@dataclass(frozen=True, slots=True)
class Post:
    """A round thing."""

    x: float
    y: float
    radius: float
    """m."""
    softness: float = 0.0
    """dB."""


@dataclass(frozen=True, slots=True)
class Furnishing:
    """What stands on a floor besides that which is in its plan."""

    screens: Sequence[Screen] = ()
    boxes: Sequence[Box] = ()
    posts: Sequence[Post] = ()
    walkers: tuple[Walker, ...] = ()

    def world(self, name: str, plan: FloorPlan, temperature: float = 20.0) -> World:
        """The world of both, at a temperature in degC."""
        outline = plan.outline()
        extra = np.array([(*screen, 0.0, 0.0) for screen in self.screens] + list(_sides(self.boxes)))
        extra = extra.reshape(-1, 6)
        round_things = np.array([(post.x, post.y, post.radius, post.softness) for post in self.posts])
        round_things = round_things.reshape(-1, 4)
        return World(
            name=name,
            walls=np.concatenate((outline.walls, extra[:, :4])),
            rough=np.concatenate((outline.rough, extra[:, 4] > 0.5)),
            cylinders=round_things[:, :3].copy(),
            temperature=temperature,
            wall_softness=np.concatenate((outline.softness, extra[:, 5])),
            cylinder_softness=round_things[:, 3].copy(),
            walkers=self.walkers,
        )


def _sides(boxes: Iterable[Box]) -> Iterator[tuple[float, ...]]:
    """The sides of all boxes, with whether they are rough and how soft."""
    for box in boxes:
        for wall in box.walls():
            yield (*wall, float(box.rough), box.softness)
