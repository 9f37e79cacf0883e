"""What a decision was taken from: the window around the robot, and the polar histogram beside it.

python -m echogrid.runtime.steering_picture FILE.png      (a made-up scene, for the docs)
"""

import sys
from math import cos, inf, radians, sin, sqrt, tau
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.steering.decision import Decision, Steering
from echogrid.mapping.steering.goal import Goal, towards
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.obstacles import MOST, Obstacles, View
from echogrid.mapping.steering.sectors import Floats, to_sectors
from echogrid.mapping.steering.vff import Vff
from echogrid.mapping.steering.vfh import Vfh
from echogrid.mapping.steering.vfh_plus import VfhPlus
from echogrid.mapping.steering.window import Body, Window
from echogrid.runtime.map_picture import PATH, UNKNOWN
from echogrid.runtime.png import encode

Pixels = NDArray[np.uint8]
Colour = tuple[int, int, int]

GOAL: Colour = (20, 150, 60)
CHOSEN: Colour = (210, 40, 40)
OPEN: Colour = (150, 190, 150)
BLOCKED: Colour = (90, 90, 90)
MASKED: Colour = (250, 215, 170)
_THRESHOLD: Colour = (150, 60, 160)
_BODY: Colour = PATH
_SCALE = 6
"""Pixels a cell, and a sector."""
_GAP = 12
_SHOWN = 2.0
"""So many times the upper threshold is shown, at least."""


def picture(view: View, decision: Decision) -> Pixels:
    """(rows, cols, 3) RGB. Left the window, north up; right the histogram, straight ahead in its middle.

    What the colours mean is told in docs/steering.md.
    """
    left, right = _window(view, decision), _histogram(view, decision)
    gap = np.full((len(left), _GAP, 3), 255, np.uint8)
    return np.concatenate([left, gap, right], axis=1)


def _window(view: View, decision: Decision) -> Pixels:
    """The cells, the robot, its goal and its heading; what is masked is tinted."""
    half = view.window.half
    size = 2 * half + 1
    cells = np.full((size, size, 3), 255, np.uint8)
    rows, cols = (
        np.rint(axis / view.window.resolution).astype(np.intp) + half
        for axis in (view.window.y, view.window.x)
    )
    cells[rows, cols] = _shades(view, decision)
    pixels = np.repeat(np.repeat(cells, _SCALE, axis=0), _SCALE, axis=1)
    _ring(pixels, view)
    _ray(pixels, view, decision.goal.bearing, min(decision.goal.distance, view.window.horizon), GOAL)
    if decision.heading is not None:
        _ray(pixels, view, decision.heading, view.window.horizon, CHOSEN)
    return pixels[::-1]


def _shades(view: View, decision: Decision) -> Pixels:
    """(n, 3) of each cell of the window: the darker the more certain."""
    grey = 255.0 * (1.0 - view.certainty / MOST)
    shades = np.repeat(np.rint(grey).astype(np.uint8)[:, np.newaxis], 3, axis=1)
    free = view.certainty == 0
    shades[free & (decision.polar.masked | view.shut)[view.window.nearest_sector]] = MASKED
    shades[free & (view.seen_ns == 0)] = UNKNOWN
    return shades


def _spots(view: View, x: Floats, y: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The pixels' rows and columns at these places (m from the robot), row 0 = south."""
    size = view.window.resolution / _SCALE
    middle = (view.window.half + 0.5) * view.window.resolution
    row = np.floor((y + view.offset[1] + middle) / size).astype(np.intp)
    col = np.floor((x + view.offset[0] + middle) / size).astype(np.intp)
    last = (2 * view.window.half + 1) * _SCALE - 2
    return np.clip(row, 1, last), np.clip(col, 1, last)


def _ring(pixels: Pixels, view: View) -> None:
    around = np.linspace(0.0, tau, 720)
    radius = view.window.body.radius
    rows, cols = _spots(view, radius * np.cos(around), radius * np.sin(around))
    pixels[rows, cols] = _BODY
    pixels[rows, cols - 1] = _BODY
    _ray(pixels, view, view.robot.yaw, radius, _BODY)


def _ray(pixels: Pixels, view: View, bearing: float, length: float, colour: Colour) -> None:
    """A line from the robot, three pixels thick."""
    along = np.linspace(0.0, length, 1000)
    rows, cols = _spots(view, along * cos(bearing), along * sin(bearing))
    for down in (-1, 0, 1):
        for across in (-1, 0, 1):
            pixels[rows + down, cols + across] = colour


def _histogram(view: View, decision: Decision) -> Pixels:
    """A bar for each sector, as high as the root of its density; lines for thresholds, goal and heading."""
    polar, n = decision.polar, view.window.sectors
    rows, cols = (2 * view.window.half + 1) * _SCALE, n * _SCALE
    pixels = np.full((rows, cols, 3), 255, np.uint8)
    top = max(float(polar.density.max()), _SHOWN * polar.high if polar.high < inf else 1e-9)
    heights = np.rint(np.sqrt(polar.density / top) * rows).astype(np.intp)
    for sector in range(n):
        bar = slice(_place(view, sector), _place(view, sector) + _SCALE - 1)
        if polar.masked[sector] or view.shut[sector]:
            pixels[:, bar] = MASKED
        pixels[: heights[sector], bar] = BLOCKED if polar.blocked[sector] else OPEN
    for threshold in (polar.low, polar.high):
        if threshold < inf:
            level = round(sqrt(threshold / top) * rows)
            pixels[max(level - 2, 0) : level] = _THRESHOLD
    _mark(pixels, view, decision.goal.bearing, GOAL)
    if decision.heading is not None:
        _mark(pixels, view, decision.heading, CHOSEN)
    return pixels[::-1]


def _mark(pixels: Pixels, view: View, bearing: float, colour: Colour) -> None:
    middle = _place(view, to_sectors(bearing, view.window.sectors)) + _SCALE // 2
    pixels[:, max(middle - 1, 0) : middle + 2] = colour


def _place(view: View, sector: float) -> int:
    """The first column of pixels of a sector; that of straight ahead is in the middle."""
    n = view.window.sectors
    left = (sector - to_sectors(view.robot.yaw, n) + n / 2.0) % n
    return int((n - left) * _SCALE) % (n * _SCALE - _SCALE + 1)


def made_up() -> tuple[View, float, Goal]:
    """A robot at 0.3 m/s that comes along a wall to a block which is in the way of its goal; nothing is known
    of what is far behind it."""
    robot, now_ns = Pose(0.02, 0.03, radians(20.0)), 1
    local = LocalGrid(0.05, 120, 0.1, 15.0, NoEcho.WEAK)
    local.centre(robot)
    x, y = local.geometry.x_centres[np.newaxis, :], local.geometry.y_centres[:, np.newaxis]
    local.grid.log_odds[:] = -2000
    local.seen_ns[:] = now_ns
    local.grid.log_odds[np.broadcast_to(np.abs(y + 0.75) < 0.1, (120, 120))] = 2000
    local.grid.log_odds[(np.abs(x - 0.95) < 0.1) & (np.abs(y - 0.2) < 0.3)] = 1600
    local.grid.log_odds[np.hypot(x - 0.2, y - 0.9) < 0.12] = 1100
    local.seen_ns[np.hypot(x - robot.x, y - robot.y) * np.sign(0.3 * y - x) > 0.9] = 0
    window = Window(0.05, 120, Body())
    return Obstacles(window).view(local, robot, now_ns), 0.3, towards(robot, 1.5, 0.4)


def main() -> None:
    """Draw the made-up scene as VFF, VFH and VFH+ see it, in this order from the top."""
    view, speed, goal = made_up()
    methods: list[Steering] = [Vff(), Vfh(view.window), VfhPlus(view.window, Limits())]
    shown = [picture(view, method.steer(view, speed, goal)) for method in methods]
    gap = np.full((_GAP, shown[0].shape[1], 3), 255, np.uint8)
    sheet = np.concatenate([shown[0], gap, shown[1], gap, shown[2]])
    Path(sys.argv[1]).write_bytes(encode(sheet))


if __name__ == "__main__":
    main()
