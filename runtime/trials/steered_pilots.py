"""Pilots that steer by the local grid: VFF, VFH and VFH+, each held to what the free path allows."""

from collections.abc import Callable
from math import cos, pi, sin

from echogrid.mapping.approach import Approach
from echogrid.mapping.braking import Brakes
from echogrid.mapping.footprint import Footprint
from echogrid.mapping.free_path import PathSensor, PathSight
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.planning.planner import Planner, Planning
from echogrid.mapping.planning.terrain import Prices
from echogrid.mapping.pose import Pose
from echogrid.mapping.steering.decision import Steering
from echogrid.mapping.steering.goal import towards
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.navigator import Moment, Navigator
from echogrid.mapping.steering.obstacles import Belief, Obstacles
from echogrid.mapping.steering.vff import Vff
from echogrid.mapping.steering.vfh import Vfh
from echogrid.mapping.steering.vfh_plus import VfhPlus
from echogrid.mapping.steering.window import Body, Window
from echogrid.mapping.twist import Twist
from echogrid.mapping.unknown import Unknown
from echogrid.runtime.trials.pilot import STANDING, Robot

Way = Callable[[Window, Limits], Steering]

_ARRIVED = 0.15
"""m: then it stops."""
_CORNERS = 36
"""Of the outline that stands for the round robot; it lies outside the circle."""
_REACH_S = 0.2
"""The wheels' own word is a while late: the motors are asked for what they can come to in that time."""
_MARGIN = 0.05
"""m that is kept from obstacles."""


class Steered:
    """A way of steering, and the robot's own limits."""

    def __init__(self, way: Way, robot: Robot, planner: Planner | None = None) -> None:
        self._way = way
        self._robot = robot
        self._limits = Limits(robot.speed, robot.turn_rate, robot.acceleration, robot.turn_acceleration)
        self._navigator: Navigator | None = None
        self._approach = Approach(robot.radius)
        self._planner = planner

    def hear(self, ping: PlacedPing) -> None:
        """The grid has it; what comes nearer by itself is seen here."""
        self._approach.take(ping)

    def step(self, now_ns: int, local: LocalGrid, pose: Pose, twist: Twist, goal: Pose) -> Twist:
        """As the navigator says, until the goal is reached."""
        there = towards(pose, goal.x, goal.y)
        if there.distance < _ARRIVED:
            return STANDING
        if self._navigator is None:
            self._navigator = self._made(local)
        moment = Moment(now_ns, pose, twist)
        if self._planner is not None:
            there = self._planner.aim(local, pose, now_ns, (goal.x, goal.y))
        twist = self._navigator.steer(local, moment, there, _REACH_S, self._latency_s).twist
        limit = self._approach.limit(now_ns, self._reaction_s, self._robot.acceleration)
        return twist if abs(twist.speed) <= limit else twist.times(limit / abs(twist.speed))

    @property
    def _latency_s(self) -> float:
        """A round of pings, and then the wheels."""
        return 0.15 + self._reaction_s

    @property
    def _reaction_s(self) -> float:
        """Two steps."""
        return 2.0 * self._robot.period_s

    def _made(self, local: LocalGrid) -> Navigator:
        robot, geometry = self._robot, local.geometry
        window = Window(geometry.resolution, geometry.rows, Body(robot.radius, _MARGIN))
        outer = robot.radius / cos(pi / _CORNERS)
        around = [2.0 * pi * (k + 0.5) / _CORNERS for k in range(_CORNERS)]
        footprint = Footprint([(outer * cos(angle), outer * sin(angle)) for angle in around])
        sight = PathSight(
            brakes=Brakes(robot.acceleration, _MARGIN),
            unknown=Unknown.SLOW,
            most=Twist(robot.speed, robot.turn_rate),
        )
        path = PathSensor(footprint, sight, geometry.resolution, geometry.rows)
        obstacles = Obstacles(window, Belief(unknown=Unknown.SLOW))
        return Navigator(self._way(window, self._limits), obstacles, path, self._limits)


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
    planning = Planning(radius=robot.radius, prices=Prices(keep=robot.radius + _MARGIN))
    return Steered(VfhPlus, robot, Planner(planning))
