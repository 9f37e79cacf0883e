"""From places and a map on the command line to a drive by that map."""

from math import radians
from pathlib import Path

from echogrid.mapping.planning.cell_map import CellMap
from echogrid.mapping.pose import Pose
from echogrid.runtime import map_reading
from echogrid.runtime.config import Config
from echogrid.runtime.errors import UsageError
from echogrid.runtime.modes import making
from echogrid.runtime.modes.goto import Goto


def goto(config: Config, path: Path, goal: tuple[float, float], start: tuple[float, float, float]) -> Goto:
    """To a goal (m), from a start (m, m and degrees), both in the map's frame.

    Raises UsageError if there is no such map, or no floor at either place.
    """
    known = map_reading.read(path)
    x, y, yaw = start
    _require_floor(known, path, "--goto", *goal)
    _require_floor(known, path, "--at", x, y)
    return making.goto_on(config, known.floor_plan(), Pose(x, y, radians(yaw)), *goal)


def _require_floor(known: CellMap, path: Path, option: str, x: float, y: float) -> None:
    cell = known.cell(x, y)
    if cell is None or known.occupied[cell]:
        where = "lies in a wall of" if cell else "lies outside"
        raise UsageError([f"{option}: {x:g} {y:g} {where} {path}: choose a place that is free there"])
