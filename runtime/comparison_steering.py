"""What steering would decide on each map of a comparison, along the way of the log's robot."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import ceil, floor, pi

import numpy as np

from echogrid.mapping.bayes import MILLI
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.long_term_map import MapImage
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.steering.decision import Decision
from echogrid.mapping.steering.goal import Goal, towards
from echogrid.mapping.steering.obstacles import Belief, Obstacles, View
from echogrid.mapping.steering.vfh_plus import VfhPlus
from echogrid.mapping.steering.window import Window
from echogrid.mapping.unknown import Unknown
from echogrid.mapping.virtual_sensor import Sector, VirtualSensor
from echogrid.runtime import assembly
from echogrid.runtime.config import Config
from echogrid.runtime.echo_tape import speed_at
from echogrid.runtime.map_suite import SUREST
from echogrid.runtime.modes import making

TRUTH = "truth"
"""The name of the map that is true."""
AHEAD_M = 1.5
"""The goal is where the log's robot was so much of its way later: so it can be reached."""
EVERY_M = 0.5
"""Of the way, between two places."""
SHOWN = 2
"""Places of which there are pictures."""
_APART_M = 3.0
_NEAREST_M = 0.3
"""A goal nearer than that has been reached."""
_HORIZON_M = 1.65
"""As far as who drives looks."""
_COARSEST_M = 0.3
"""In larger cells there is nothing to steer by."""
_NOW_NS = 1_000_000_000_000
"""Maps do not age, so any moment will do that is long after 0, which is never."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where the log's robot was, and where it went from there."""

    pose: Pose
    speed: float
    """m/s."""
    goal: Goal


@dataclass(frozen=True, slots=True)
class Choice:
    """What is decided at a place by one map, and from what."""

    view: View
    sectors: tuple[Sector, ...]
    """Of the virtual sensor."""
    decision: Decision


@dataclass(frozen=True, slots=True)
class Outcome:
    """What becomes of a choice."""

    heading: float | None
    """rad, in the map's frame; None: no way is open."""
    promised: float | None
    """m that the robot's disc can go there by the map, until it touches; what the window shows at most."""
    free: float | None
    """m that it can go there in truth; None: there is no heading, or no truth."""


@dataclass(frozen=True, slots=True)
class Scene:
    """A place with what is decided there, by the name of the map."""

    place: Place
    choices: Mapping[str, Choice]
    outcomes: Mapping[str, Outcome]


@dataclass(frozen=True, slots=True)
class Steered:
    """What is decided all along the way."""

    outcomes: Mapping[str, tuple[Outcome, ...]]
    """By the name of the map, at each of the places."""
    places: tuple[Place, ...]
    scenes: tuple[Scene, ...]
    """The places where the theories differ most."""


class Helm:
    """VFH+ and the virtual sensor of a robot, which take a map for its local grid."""

    def __init__(self, config: Config, resolution: float) -> None:
        self._cells = max(round(config.local.size_m / resolution), 2 * ceil(_HORIZON_M / resolution) + 1)
        self._resolution = resolution
        self._window = Window(resolution, self._cells, making.body(config), _HORIZON_M)
        self._obstacles = Obstacles(self._window, Belief(unknown=Unknown.SLOW))
        self._sensor = VirtualSensor(assembly.sight(config), resolution, self._cells)
        self._limits = making.limits(config)

    def choice(self, image: MapImage, place: Place) -> Choice:
        """What is decided there; by who remembers nothing."""
        local, robot = self._around(image, place.pose)
        view = self._obstacles.view(local, robot, _NOW_NS)
        decision = VfhPlus(self._window, self._limits).steer(view, place.speed, place.goal)
        return Choice(view, self._sensor.view(local, robot, _NOW_NS).sectors, decision)

    def _around(self, image: MapImage, pose: Pose) -> tuple[LocalGrid, Pose]:
        """The map around the robot as its local grid, and the robot in the frame of the map's corner."""
        geometry = image.geometry
        robot = Pose(pose.x - geometry.x, pose.y - geometry.y, pose.yaw)
        local = LocalGrid(self._resolution, self._cells, self._resolution, 1.0, NoEcho.WEAK)
        local.centre(robot)
        row, col = (floor(at / self._resolution) - self._cells // 2 for at in (robot.y, robot.x))
        here, there = _overlap(row, self._cells, geometry.rows), _overlap(col, self._cells, geometry.cols)
        inside, on_map = (here[0], there[0]), (here[1], there[1])
        p = np.clip(image.occupancy[on_map].astype(np.float64), SUREST, 1.0 - SUREST)
        known = ~image.unknown[on_map]
        local.grid.log_odds[inside] = np.where(known, np.rint(MILLI * np.log(p / (1.0 - p))), 0.0)
        local.seen_ns[inside] = np.where(known, _NOW_NS, 0)
        return local, robot


def steered(config: Config, poses: Sequence[tuple[int, Pose]], maps: Mapping[str, MapImage]) -> Steered:
    """What is decided on each of the maps, the true one being `TRUTH`. Nothing where cells are too large."""
    resolution = next(iter(maps.values())).geometry.resolution
    if resolution > _COARSEST_M:
        return Steered(dict.fromkeys(maps, ()), (), ())
    helm, way = Helm(config, resolution), places(poses)
    found = [_scene(helm, maps, place).outcomes for place in way]
    odds = [_odds([outcome for name, outcome in here.items() if name != TRUTH]) for here in found]
    return Steered(
        {name: tuple(here[name] for here in found) for name in maps},
        tuple(way),
        # Decided anew: to keep what all the others were decided from would take too much.
        tuple(_scene(helm, maps, way[index]) for index in _most_at_odds(way, odds)),
    )


def places(poses: Sequence[tuple[int, Pose]]) -> list[Place]:
    """Places along the way, each with a goal further on. There are none where the robot jumps, or comes back
    at once."""
    stamps = np.array([stamp_ns for stamp_ns, _ in poses], np.int64)
    track = np.array([[pose.x, pose.y] for _, pose in poses])
    strides = np.hypot(*np.diff(track, axis=0).T)
    way = np.concatenate([[0.0], np.cumsum(np.where(strides < AHEAD_M, strides, 0.0))])
    at = np.unique(np.searchsorted(way, np.arange(0.0, way[-1] - AHEAD_M, EVERY_M)))
    goals = np.minimum(np.searchsorted(way, way[at] + AHEAD_M), len(way) - 1)
    speeds = speed_at(list(poses), stamps[at])
    found = (
        Place(poses[here][1], float(speed), towards(poses[here][1], *track[goal]))
        for here, goal, speed in zip(at, goals, speeds, strict=True)
    )
    return [place for place in found if _NEAREST_M < place.goal.distance < 2.0 * AHEAD_M]


def _scene(helm: Helm, maps: Mapping[str, MapImage], place: Place) -> Scene:
    choices = {name: helm.choice(image, place) for name, image in maps.items()}
    true = choices[TRUTH].view if TRUTH in maps else None
    return Scene(place, choices, {name: _outcome(choice, true) for name, choice in choices.items()})


def _outcome(choice: Choice, true: View | None) -> Outcome:
    heading = choice.decision.heading
    if heading is None:
        return Outcome(None, None, None)
    free = None if true is None else true.clearance(heading)
    return Outcome(heading, choice.view.clearance(heading), free)


def _odds(outcomes: Sequence[Outcome]) -> float:
    """How far the headings are apart on the mean of all pairs, rad; no way at all is opposite to any."""
    apart = [
        abs(wrap_angle(one.heading - other.heading))
        if one.heading is not None and other.heading is not None
        else pi * ((one.heading is None) != (other.heading is None))
        for one, other in combinations(outcomes, 2)
    ]
    return sum(apart) / max(len(apart), 1)


def _most_at_odds(way: Sequence[Place], odds: Sequence[float]) -> list[int]:
    """Which places to show, in their order: those of the greatest odds that lie well apart."""
    found: list[int] = []
    for index in sorted(range(len(way)), key=lambda index: -odds[index]):
        here = way[index].pose
        if all(towards(here, way[each].pose.x, way[each].pose.y).distance >= _APART_M for each in found):
            found.append(index)
    return sorted(found[:SHOWN])


def _overlap(first: int, size: int, whole: int) -> tuple[slice, slice]:
    """Of a window that begins there on a whole: which part of the window, and of the whole, both have."""
    start, end = min(max(first, 0), whole), min(max(first + size, 0), whole)
    return slice(start - first, end - first), slice(start, end)
