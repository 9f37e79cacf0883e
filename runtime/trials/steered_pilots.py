"""Pilots that steer by the local grid: VFF, VFH and VFH+; what of it is safe the guard says."""

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.planning.floor_plan import FloorPlan
from echogrid.mapping.planning.planner import Planner
from echogrid.mapping.planning.tracking import PlanTracker
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
from echogrid.runtime.trials.pilot import STANDING, Robot

_ARRIVED = 0.15
"""m: then it stops."""


class Steered:
    """The robot's own navigator, with a way of steering; where there is a planner, along its way."""

    guarded = True

    def __init__(
        self,
        way: making.Way,
        robot: Robot,
        planner: Planner | None = None,
        tracker: PlanTracker | None = None,
    ) -> None:
        self.tracker = tracker
        self._robot = robot
        self._navigator = making.navigator(robot.config, way)
        self._planner = planner

    def hear(self, ping: PlacedPing) -> None:
        """The grid has it."""

    def step(self, now_ns: int, local: LocalGrid, pose: Pose, twist: Twist, goal: Pose) -> Twist:
        """As the navigator says, until the goal is reached."""
        frame = self.tracker.drift if self.tracker else ORIGIN
        here = frame.compose(pose)
        there = towards(here, goal.x, goal.y)
        if there.distance < _ARRIVED:
            return STANDING
        if self._planner is not None:
            there = self._planner.aim(local, here, now_ns, (goal.x, goal.y), frame)
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
    return Steered(VfhPlus, robot, making.planner(_outline(robot)))


def guided(robot: Robot) -> Steered:
    """Along a way by an architect's plan, on which the robot knows by its echoes where it is."""
    return _by(robot.floor_plan(False), robot)


def mapped(robot: Robot) -> Steered:
    """The same by a map of all that stands."""
    return _by(robot.floor_plan(True), robot)


def _by(plan: FloorPlan, robot: Robot) -> Steered:
    planner = making.planner(_outline(robot), plan)
    return Steered(Follow, robot, planner, PlanTracker(plan, Pose()))


def _outline(robot: Robot) -> Body:
    return Body(robot.radius, robot.config.avoid.margin_m)
