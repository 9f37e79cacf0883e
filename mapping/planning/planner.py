"""From what the robot has seen so far to where it should head for now, so that it comes to its goal."""

from dataclasses import dataclass, field, replace

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.planning.floor_plan import FloorPlan, placed
from echogrid.mapping.planning.recollection import Recollection, Remembering
from echogrid.mapping.planning.route import Route, found
from echogrid.mapping.planning.terrain import Point, Prices, Terrain, terrain
from echogrid.mapping.pose import ORIGIN, Pose, wrap_angle
from echogrid.mapping.steering.goal import Goal, towards

_ROUND_ABOUT = 3.0
"""m around robot and goal that are there to be driven through, seen or not."""


@dataclass(frozen=True, slots=True)
class Planning:
    """How it plans."""

    radius: float = 0.2
    """m, of the robot."""
    resolution: float = 0.1
    """m, of the memory's cells."""
    prices: Prices = field(default_factory=Prices)
    remembering: Remembering = field(default_factory=Remembering)
    look_ahead: float = 1.5
    """m of way to the point that is headed for, at most."""
    take_ns: int = 250_000_000
    """From one look at the local grid to the next."""
    replan_ns: int = 1_000_000_000
    hurry_ns: int = 500_000_000
    """From one plan to the next, if the way has become blocked."""
    gain: float = 0.5
    """m that another way must be shorter, dear stretches counted as longer, and ..."""
    gain_part: float = 0.1
    """... the part of the old way's length."""
    aside: float = 0.5
    """m: a way that is never farther than that from the old one is the same and replaces it at once."""
    relent_ns: int | None = 5_000_000_000
    """After so long without any way it forgets what it does not see now; None if never."""


class Planner:
    """One thread owns it. Time is an argument, and all else comes of what it was given."""

    def __init__(self, planning: Planning | None = None, plan: FloorPlan | None = None) -> None:
        """With a plan all is in the plan's frame."""
        self.planning = planning or Planning()
        self.memory = Recollection(self.planning.resolution, self.planning.remembering)
        if plan is not None:
            self.memory.study(plan)
        self.route: Route | None = None
        """The way it goes by; None before the first and while there is none."""
        self.carrot: Point | None = None
        """m: the point that was last headed for."""
        self._goal: Point | None = None
        self._ground: Terrain | None = None
        self._taken_ns: int | None = None
        self._planned_ns: int | None = None
        self._lost_ns: int | None = None
        """Since when there is no way."""

    @property
    def reachable(self) -> bool:
        """Whether a way to the goal was there when it last planned; what is unknown counts as open."""
        return self._lost_ns is None

    def aim(self, local: LocalGrid, robot: Pose, now_ns: int, goal: Point, frame: Pose = ORIGIN) -> Goal:
        """Where to head for now: a point of the way, and how far it is from here on to its end.

        If there is no way it is the goal itself, straight. `frame` is the pose of the local grid's frame in
        that of robot and goal; what comes back is in the local grid's. The grid is centred on the robot.
        """
        here = (robot.x, robot.y)
        if goal != self._goal:
            self._goal, self.route, self._planned_ns, self._lost_ns = goal, None, None, None
        if self._taken_ns is None or now_ns - self._taken_ns >= self.planning.take_ns:
            self._take(local, here, now_ns, frame)
        if self._is_due(here, now_ns, goal):
            self._plan(here, now_ns, goal)
        return self._aimed(robot, goal, frame)

    def _take(self, local: LocalGrid, here: Point, now_ns: int, frame: Pose) -> None:
        self._taken_ns = now_ns
        self.memory.take(local, now_ns, frame)
        self.memory.tread(*here, self.planning.radius)
        self._ground = None

    def _survey(self, here: Point, goal: Point) -> Terrain:
        """The ground by what is remembered now."""
        if self._ground is None:
            for x, y in (here, goal):
                self.memory.cover(x, y, _ROUND_ABOUT)
            self._ground = terrain(self.memory, self.planning.prices, (here, goal))
        return self._ground

    def _is_due(self, here: Point, now_ns: int, goal: Point) -> bool:
        if self._planned_ns is None:
            return True
        since = now_ns - self._planned_ns
        if since >= self.planning.replan_ns or since < self.planning.hurry_ns:
            return since >= self.planning.replan_ns
        return self.route is not None and self.route.is_shut(self._survey(here, goal), here)

    def _plan(self, here: Point, now_ns: int, goal: Point) -> None:
        self._planned_ns, self._ground = now_ns, None
        new = found(self._survey(here, goal), here, goal)
        if new is None and self._relents(now_ns):
            self.memory.relent()
            self._ground = None
            new = found(self._survey(here, goal), here, goal)
        if new is not None:
            self._lost_ns = None
            self.route = self._better(new, here)
        else:
            self.route = None
            self._lost_ns = now_ns if self._lost_ns is None else self._lost_ns

    def _relents(self, now_ns: int) -> bool:
        patience = self.planning.relent_ns
        return patience is not None and self._lost_ns is not None and now_ns - self._lost_ns >= patience

    def _better(self, new: Route, here: Point) -> Route:
        """The new way, unless the old one is another and not much worse."""
        if self.route is None or self._ground is None:
            return new
        old = self.route.left(self._ground, here)
        if new.beside(old, self.planning.aside) or old.end != new.end:
            return new
        price = old.price(self._ground)
        gain = max(self.planning.gain, self.planning.gain_part * price)
        return old if price - new.price(self._ground) < gain else new

    def _aimed(self, robot: Pose, goal: Point, frame: Pose) -> Goal:
        back, here = frame.inverse(), (robot.x, robot.y)
        if self.route is None:
            self.carrot = None
            straight = towards(robot, *goal)
            return replace(straight, bearing=wrap_angle(straight.bearing + back.yaw))
        self.carrot, length = self.route.carrot(self._survey(here, goal), here, self.planning.look_ahead)
        near = towards(robot, *self.carrot)
        way = placed(self.route.ahead(here, self.planning.look_ahead), back).tolist()
        return Goal(wrap_angle(near.bearing + back.yaw), length, tuple((x, y) for x, y in way), near.distance)
