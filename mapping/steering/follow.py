"""Along a planned way as long as the robot fits through beside all that is seen; else by VFH+."""

from dataclasses import replace
from math import atan2, hypot

import numpy as np

from echogrid.mapping.steering.decision import Decision, Why
from echogrid.mapping.steering.goal import Goal, Point
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.obstacles import View
from echogrid.mapping.steering.vfh_plus import VfhPlus
from echogrid.mapping.steering.window import Window

_SPARE = 0.01
"""m that is kept at least where the way is narrower than the margin."""
_NEAREST = 0.25
"""m: a point that is nearer says little of a direction."""
_CLOSE = 0.08
"""m: but where it is too narrow for the others, it has to do."""


class Follow:
    """Heads for the farthest point of the way to which it fits straight, with its whole margin if it can."""

    def __init__(self, window: Window, limits: Limits) -> None:
        self._around = VfhPlus(window, limits)

    def steer(self, view: View, speed: float, goal: Goal) -> Decision:
        """Along the way; around what stands in it."""
        near = replace(goal, distance=min(goal.distance, goal.near))
        decision = replace(self._around.steer(view, speed, near), goal=goal)
        if view.touching or not goal.way:
            return decision
        point = self._ahead(view, goal.way)
        if point is None:
            return decision
        heading = atan2(point[1] - view.robot.y, point[0] - view.robot.x)
        return Decision(heading, 1.0, Why.TARGET, goal, decision.polar)

    def forget(self) -> None:
        """Begin anew."""
        self._around.forget()

    def _ahead(self, view: View, way: tuple[Point, ...]) -> Point | None:
        """The farthest point that can be driven to straight."""
        robot, margin = view.robot, view.window.body.margin
        away = [hypot(x - robot.x, y - robot.y) for x, y in way]
        for least, kept in ((_NEAREST, margin), (_NEAREST, min(_SPARE, margin)), (_CLOSE, 0.0)):
            points = [point for point, far in zip(way, away, strict=True) if far >= min(least, away[-1])]
            (fitting,) = view.fits(np.array(points), kept).nonzero()
            if len(fitting):
                return points[int(fitting[-1])]
        return None
