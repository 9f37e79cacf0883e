"""To a goal on a map, through all bytes: emulated rangers and motors, and the room's true walls as a map."""

from collections.abc import Callable
from dataclasses import replace
from math import ceil, hypot
from pathlib import Path

import numpy as np
import pytest

from echogrid.emulation.floor_plan import Rectangle
from echogrid.emulation.world import World
from echogrid.runtime import robot_file
from echogrid.runtime.config import Config
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.errors import UsageError
from echogrid.runtime.modes import by_map
from echogrid.runtime.voyage import Leg

from .driven_run import START, Drive, room

DOOR: tuple[Rectangle, ...] = ((3.0, 0.0, 3.1, 3.2), (3.0, 4.4, 3.1, 5.0))
"""A wall across the room, and a door of 1.2 m in it, aside of the straight way to what is behind."""
BEHIND = 4.2, 1.8
STANDS = START.x, START.y, 0.0
CELL = 0.05
WEST, SOUTH = -0.5, -0.5


@pytest.fixture(scope="module")
def config() -> Config:
    """The built-in robot, whose rangers hear less of each other, and that passes nearer by things."""
    built_in = robot_file.load(DEFAULT_ROBOT)
    quiet = replace(built_in.firing, mode="eeruf", groups=(), gap_ms=None)
    return replace(built_in, firing=quiet, obstacle=replace(built_in.obstacle, stop_distance_m=0.3))


def drawn(world: World, folder: Path) -> Path:
    """A world's walls, in its own frame, as a map_server's files."""
    pixels = np.full((120, 180), 254, np.uint8)
    for x0, y0, x1, y1 in world.walls.tolist():
        count = ceil(hypot(x1 - x0, y1 - y0) / CELL) * 4 + 1
        rows = np.floor((np.linspace(y0, y1, count) - SOUTH) / CELL + 1e-9).astype(np.intp)
        cols = np.floor((np.linspace(x0, x1, count) - WEST) / CELL + 1e-9).astype(np.intp)
        pixels[rows, cols] = 0
    (folder / "room.pgm").write_bytes(b"P5\n180 120\n255\n" + pixels[::-1].tobytes())
    head = f"image: room.pgm\nresolution: {CELL}\norigin: [{WEST}, {SOUTH}, 0.0]\n"
    (folder / "room.yaml").write_text(f"{head}negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n")
    return folder / "room.yaml"


Begun = Callable[..., Drive]


@pytest.fixture
def begun(config: Config, tmp_path: Path) -> Begun:
    def made(start: tuple[float, float, float] = STANDS, goal: tuple[float, float] = BEHIND) -> Drive:
        world = room(*DOOR)
        return Drive(config, by_map.goto(config, drawn(world, tmp_path), goal, start), world)

    return made


def test_it_goes_through_the_door_to_what_is_behind_the_wall_and_knows_where_it_is(begun: Begun) -> None:
    drive = begun()
    drive.go(90.0)
    end = drive.voyage.end
    assert end
    assert end.reached, end.told
    assert end.told.startswith("there: ")
    assert drive.voyage.leg is Leg.OVER
    last = drive.poses[-1]
    assert hypot(last.x - BEHIND[0], last.y - BEHIND[1]) < 0.3
    assert drive.nearest() > 0.05
    assert drive.run.travelled < 7.0
    report = drive.run.report([])["drive"]["on_map"]
    assert hypot(report["x_m"] - BEHIND[0], report["y_m"] - BEHIND[1]) < 0.2
    assert 0.0 < report["deviation"]["x_m"] < 0.15


def test_who_stands_elsewhere_than_told_ends_and_touches_nothing(begun: Begun) -> None:
    drive = begun((6.5, 1.0, 0.0), (6.0, 4.0))
    drive.go(200.0)
    end = drive.voyage.end
    assert end
    assert not end.reached
    assert end.told.startswith(("lost: the echoes do not fit the map", "stuck: "))
    assert drive.voyage.leg is Leg.OVER
    assert drive.nearest() > 0.0


@pytest.mark.parametrize(
    ("start", "goal", "told"),
    [
        (STANDS, (9.0, 2.0), "--goto: 9 2 lies outside "),
        (STANDS, (3.02, 2.0), "--goto: 3.02 2 lies in a wall of "),
        ((3.02, 2.0, 0.0), BEHIND, "--at: 3.02 2 lies in a wall of "),
        ((-3.0, 2.0, 0.0), BEHIND, "--at: -3 2 lies outside "),
    ],
)
def test_where_there_is_no_floor_is_refused_at_once(
    begun: Begun, start: tuple[float, float, float], goal: tuple[float, float], told: str
) -> None:
    with pytest.raises(UsageError) as raised:
        begun(start, goal)
    assert told in str(raised.value)
    assert "room.yaml: choose a place that is free there" in str(raised.value)
    assert len(raised.value.problems) == 1
