"""The modes that steer, from a robot's configuration."""

from collections.abc import Callable
from dataclasses import replace
from math import radians, sin

from echogrid.mapping.planning.floor_plan import FloorPlan
from echogrid.mapping.planning.planner import Planner, Planning
from echogrid.mapping.planning.recollection import Remembering
from echogrid.mapping.planning.terrain import Prices
from echogrid.mapping.planning.tracking import PlanTracker
from echogrid.mapping.pose import Pose
from echogrid.mapping.steering.decision import Steering
from echogrid.mapping.steering.follow import Follow
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.navigator import Navigator
from echogrid.mapping.steering.obstacles import Belief, Obstacles
from echogrid.mapping.steering.vfh_plus import VfhPlus
from echogrid.mapping.steering.window import Body, Window
from echogrid.runtime import assembly
from echogrid.runtime.config import Config, LoopConfig
from echogrid.runtime.drive_run import LEAST_HZ
from echogrid.runtime.hull import footprint
from echogrid.runtime.modes.goto import Goto
from echogrid.runtime.modes.guide import Guide
from echogrid.runtime.modes.wander import Wander

Way = Callable[[Window, Limits], Steering]
"""What makes a way of steering for a robot."""

_AHEAD = radians(45.0)
"""The half angle in which the stop layer stops whoever drives ahead."""
_PATIENCE = 12
"""So many looks in a row: three seconds, in which who passes by is gone."""


def brisk(config: Config) -> Config:
    """The same with a loop that is quick enough to drive by."""
    return replace(config, loop=LoopConfig(max(config.loop.rate_hz, LEAST_HZ)))


def goto(config: Config, x: float, y: float) -> Goto:
    """Towards a point (m, odom frame)."""
    return Goto(navigator(config), x, y)


def goto_on(config: Config, plan: FloorPlan, start: Pose, x: float, y: float) -> Goto:
    """Towards a point (m) of a floor plan, on which the robot starts at that pose."""
    outline = body(config)
    plan = plan.without(start.x, start.y, outline.radius + outline.margin)
    guide = guide_on(plan, start, outline)
    return Goto(navigator(config, Follow), x, y, guide)


def wander(config: Config, seed: int) -> Wander:
    """Wherever it is free; by that seed."""
    return Wander(navigator(config), seed)


def navigator(config: Config, way: Way = VfhPlus) -> Navigator:
    """For that robot, as a disc, and within its limits."""
    local, sight = config.local, assembly.path_sight(config)
    cells = round(local.size_m / local.resolution_m)
    window = Window(local.resolution_m, cells, body(config))
    obstacles = Obstacles(window, Belief(unknown=sight.unknown, stale_ns=sight.stale_ns))
    return Navigator(way(window, limits(config)), obstacles, limits(config))


def guide_on(plan: FloorPlan, start: Pose, outline: Body) -> Guide:
    """By a floor plan, on which the robot starts at that pose."""
    return Guide(planner(outline, plan), PlanTracker(plan, start))


def planner(outline: Body, plan: FloorPlan | None = None) -> Planner:
    """For a robot as a disc, and what it keeps. Who has a plan believes only in what stays."""
    remembering = Remembering(patience=_PATIENCE) if plan else Remembering()
    prices = Prices(keep=outline.radius + outline.margin)
    return Planner(Planning(radius=outline.radius, prices=prices, remembering=remembering), plan)


def body(config: Config) -> Body:
    """The robot as a disc, and what it keeps: what it passes by straight ahead must not be where the stop
    layer stops it."""
    reach = footprint(config).reach
    stops_at = config.obstacle.stop_distance_m + (reach if config.robot.footprint else 0.0)
    return Body(reach, max(config.avoid.margin_m, stops_at * sin(_AHEAD) - reach))


def limits(config: Config) -> Limits:
    """Within what it steers."""
    return Limits(
        config.drive.max_speed_mps,
        radians(config.drive.max_turn_dps),
        min(config.drive.acceleration_mps2, config.avoid.deceleration_mps2),
    )
