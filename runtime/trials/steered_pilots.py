"""Pilots that steer by the local grid: VFF, VFH and VFH+; what of it is safe the guard says."""

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.planning.floor_plan import FloorPlan
from echogrid.mapping.pose import ORIGIN, Pose
from echogrid.mapping.steering.follow import Follow
from echogrid.mapping.steering.goal import towards
from echogrid.mapping.steering.navigator import Moment
from echogrid.mapping.steering.vff import Vff
from echogrid.mapping.steering.vfh import Vfh
from echogrid.mapping.steering.vfh_plus import VfhPlus
from echogrid.mapping.steering.window import Body
from echogrid.mapping.twist import Twist
from echogrid.runtime.modes import making
from echogrid.runtime.modes.guide import Guide
from echogrid.runtime.trials.pilot import STANDING, Robot

_ARRIVED = 0.15
"""m: then it stops."""


class Steered:
    """The robot's own navigator, with a way of steering; with a guide, along its way."""

    guarded = True

    def __init__(self, way: making.Way, robot: Robot, guide: Guide | None = None) -> None:
        self.tracker = guide.tracker if guide else None
        self._robot = robot
        self._navigator = making.navigator(robot.config, way)
        self._guide = guide

    def hear(self, ping: PlacedPing) -> None:
        """The grid has it."""

    def step(self, now_ns: int, local: LocalGrid, pose: Pose, twist: Twist, goal: Pose) -> Twist:
        """As the navigator says, until the goal is reached."""
        there = towards(self._guide.here(pose) if self._guide else pose, goal.x, goal.y)
        if there.distance < _ARRIVED:
            return STANDING
        if self._guide:
            there = self._guide.aim(local, pose, now_ns, (goal.x, goal.y))
        return self._navigator.steer(local, Moment(now_ns, pose, twist), there, self._robot.period_s).twist


def vff(robot: Robot) -> Steered:
    """Virtual forces (1989)."""
    return Steered(lambda _window, _limits: Vff(), robot)


def vfh(robot: Robot) -> Steered:
    """The vector field histogram (1991)."""
    return Steered(lambda window, _limits: Vfh(window), robot)


def vfh_plus(robot: Robot) -> Steered:
    """VFH+ (1998)."""
    return Steered(VfhPlus, robot)


def planned(robot: Robot) -> Steered:
    """VFH+ towards the next stretch of a way that is planned over all that was seen so far."""
    return Steered(VfhPlus, robot, Guide(making.planner(_outline(robot))))


def guided(robot: Robot) -> Steered:
    """Along a way by an architect's plan, on which the robot knows by its echoes where it is."""
    return _by(robot.floor_plan(False), robot)


def mapped(robot: Robot) -> Steered:
    """The same by a map of all that stands."""
    return _by(robot.floor_plan(True), robot)


def _by(plan: FloorPlan, robot: Robot) -> Steered:
    return Steered(Follow, robot, making.guide_on(plan, ORIGIN, _outline(robot)))


def _outline(robot: Robot) -> Body:
    return Body(robot.radius, robot.config.avoid.margin_m)
