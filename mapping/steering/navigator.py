"""A way of steering with all that belongs to it: from a local grid and a goal to a twist to drive."""

from dataclasses import dataclass

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.steering.decision import Decision, Steering
from echogrid.mapping.steering.goal import Goal
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.obstacles import Obstacles
from echogrid.mapping.steering.pace import Pace
from echogrid.mapping.steering.recovery import Recovery
from echogrid.mapping.twist import Twist


@dataclass(frozen=True, slots=True)
class Moment:
    """What is so now."""

    now_ns: int
    robot: Pose
    """In the grid's frame."""
    twist: Twist
    """That it drives."""


@dataclass(frozen=True, slots=True)
class Course:
    """What comes of it."""

    twist: Twist
    """To drive from now on, as far as that is safe."""
    decision: Decision


class Navigator:
    """One thread owns it. The grid is centred on the robot before it is asked.

    What it asks for is still to be looked at by who knows the robot's outline and brakes (Lookout.allowed).
    """

    def __init__(self, steering: Steering, obstacles: Obstacles, limits: Limits) -> None:
        self._steering = steering
        self._obstacles = obstacles
        self._limits = limits
        self._pace = Pace(limits)
        self.recovery = Recovery(limits)

    def steer(self, local: LocalGrid, moment: Moment, goal: Goal, elapsed_s: float) -> Course:
        """The twist on a heading of the steering's own that can be come to in `elapsed_s`, the time since the
        last one."""
        view = self._obstacles.view(local, moment.robot, moment.now_ns)
        decision = self._steering.steer(view, moment.twist.speed, goal)
        wish = self.recovery.wish(moment.now_ns, view, decision, moment.twist)
        wish = wish if wish is not None else self._pace.wish(view, decision)
        return Course(self._limits.reach(wish, moment.twist, elapsed_s), decision)
