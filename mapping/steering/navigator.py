"""A way of steering with all that belongs to it: from a local grid and a goal to a twist to drive."""

from dataclasses import dataclass

from echogrid.mapping.free_path import FreePath, PathSensor
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
    """To drive from now on."""
    decision: Decision
    path: FreePath
    """The way along the twist that was wished for, and what of it is allowed."""


class Navigator:
    """One thread owns it. The grid is centred on the robot before it is asked."""

    def __init__(self, steering: Steering, obstacles: Obstacles, path: PathSensor, limits: Limits) -> None:
        self._steering = steering
        self._obstacles = obstacles
        self._path = path
        self._limits = limits
        self._pace = Pace(limits)
        self.recovery = Recovery(limits)

    def steer(
        self, local: LocalGrid, moment: Moment, goal: Goal, elapsed_s: float, latency_s: float
    ) -> Course:
        """The twist from which the robot still stops in time, on a heading of the steering's own.

        `elapsed_s` is the time since the last one; `latency_s` from an obstacle's echo to the wheels.
        """
        view = self._obstacles.view(local, moment.robot, moment.now_ns)
        decision = self._steering.steer(view, moment.twist.speed, goal)
        wish = self.recovery.wish(moment.now_ns, view, decision, moment.twist.speed)
        wish = wish if wish is not None else self._pace.wish(view, decision)
        reached = self._limits.reach(wish, moment.twist, elapsed_s)
        path = self._path.look(local, moment.robot, moment.now_ns, reached, latency_s)
        turns = reached.speed == 0.0  # The body is a disc: in place it turns without hitting anything.
        return Course(reached if turns else path.allowed, decision, path)
