"""What a decision was taken from: the window around the robot, and the polar histogram.

python -m echogrid.runtime.steering_picture FILE.png      (a made-up scene, for the docs)
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from math import radians
from pathlib import Path

import numpy as np

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.steering.decision import Decision, Steering
from echogrid.mapping.steering.goal import Goal, towards
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.obstacles import Obstacles, View
from echogrid.mapping.steering.vff import Vff
from echogrid.mapping.steering.vfh import Vfh
from echogrid.mapping.steering.vfh_plus import VfhPlus
from echogrid.mapping.steering.window import Body, Window
from echogrid.mapping.virtual_sensor import Sector, Sight, VirtualSensor
from echogrid.runtime import polar_picture, steering_window
from echogrid.runtime.picture_sheet import GAP, Picture, sheet
from echogrid.runtime.png import encode
from echogrid.runtime.steering_window import Pixels

_CELL = 6
"""Pixels for each, and for each sector."""
_PANEL = 250
"""Pixels along a panel's window, about."""
_BAR = 3
_BARS = 80
"""Pixels: how wide the histogram's bars are in a panel, and how high they may be."""


@dataclass(frozen=True, slots=True)
class Scene:
    """A robot, what is around it, and where it is to go."""

    view: View
    sectors: tuple[Sector, ...]
    """Of the virtual sensor."""
    speed: float
    """m/s."""
    goal: Goal


def picture(view: View, decision: Decision, sectors: Sequence[Sector]) -> Pixels:
    """(rows, cols, 3) RGB. Left the window, north up, within the ring of the virtual sensor's sectors; right
    the histogram, straight ahead in its middle.

    What the colours mean is told in docs/steering.md.
    """
    left = steering_window.drawn(view, decision, sectors, _CELL)
    right = polar_picture.drawn(view, decision, len(left), _CELL)
    gap = np.full((len(left), GAP, 3), 255, np.uint8)
    return np.concatenate([left, gap, right], axis=1)


def panel(view: View, decision: Decision, sectors: Sequence[Sector]) -> Pixels:
    """(rows, cols, 3) the same for pictures side by side: smaller, with the histogram beneath the window."""
    above = steering_window.drawn(view, decision, sectors, max(1, _PANEL // (2 * view.window.half + 1)))
    beneath = polar_picture.drawn(view, decision, _BARS, _BAR)
    wide = max(above.shape[1], beneath.shape[1])
    gap = np.full((GAP, wide, 3), 255, np.uint8)
    return np.concatenate([_widened(above, wide), gap, _widened(beneath, wide)])


def _widened(pixels: Pixels, wide: int) -> Pixels:
    """The same with white on both sides."""
    left = (wide - pixels.shape[1]) // 2
    room = ((0, 0), (left, wide - pixels.shape[1] - left), (0, 0))
    return np.pad(pixels, room, constant_values=255)


def made_up() -> Scene:
    """A robot at 0.3 m/s that comes along a wall to a block which is in the way of its goal; nothing is known
    of what is far behind it."""
    robot, now_ns = Pose(0.02, 0.03, radians(20.0)), 10_000_000_000
    local = LocalGrid(0.05, 120, 0.1, 15.0, NoEcho.WEAK)
    local.centre(robot)
    x, y = local.geometry.x_centres[np.newaxis, :], local.geometry.y_centres[:, np.newaxis]
    local.grid.log_odds[:] = -2000
    local.seen_ns[:] = now_ns
    local.grid.log_odds[np.broadcast_to(np.abs(y + 0.75) < 0.1, (120, 120))] = 2000
    local.grid.log_odds[(np.abs(x - 0.95) < 0.1) & (np.abs(y - 0.2) < 0.3)] = 1600
    local.grid.log_odds[np.hypot(x - 0.2, y - 0.9) < 0.12] = 1100
    unseen = np.hypot(x - robot.x, y - robot.y) * np.sign(0.3 * y - x) > 0.9
    local.seen_ns[unseen] = 0
    local.grid.log_odds[unseen & (local.grid.log_odds < 0)] = 0
    view = Obstacles(Window(0.05, 120, Body())).view(local, robot, now_ns)
    sectors = VirtualSensor(Sight(), 0.05, 120).view(local, robot, now_ns).sectors
    return Scene(view, sectors, 0.3, towards(robot, 1.5, 0.4))


def main() -> None:
    """Draw the made-up scene as VFF, VFH and VFH+ see it, in this order from the top."""
    scene = made_up()
    window = scene.view.window
    methods: dict[str, Steering] = {"VFF": Vff(), "VFH": Vfh(window), "VFH+": VfhPlus(window, Limits())}
    shown = [
        Picture(
            name, "", picture(scene.view, method.steer(scene.view, scene.speed, scene.goal), scene.sectors)
        )
        for name, method in methods.items()
    ]
    Path(sys.argv[1]).write_bytes(encode(sheet(shown, abreast=1)))


if __name__ == "__main__":
    main()
