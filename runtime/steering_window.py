"""The window from which a decision was taken, as a picture: cells, sectors, robot, goal and heading."""

from collections.abc import Sequence
from math import cos, sin, tau

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.steering.decision import Decision
from echogrid.mapping.steering.obstacles import MOST, View
from echogrid.mapping.steering.sectors import Floats
from echogrid.mapping.virtual_sensor import Sector, SectorState
from echogrid.runtime.map_picture import PATH, UNKNOWN

Pixels = NDArray[np.uint8]
Colour = tuple[int, int, int]

GOAL: Colour = (20, 150, 60)
CHOSEN: Colour = (210, 40, 40)
OPEN: Colour = (150, 190, 150)
BLOCKED: Colour = (90, 90, 90)
MASKED: Colour = (250, 215, 170)
STALE: Colour = (205, 190, 130)
NEAREST: Colour = (225, 120, 30)
"""The arc at a sector's nearest obstacle."""
STATES = {
    SectorState.CLEAR: OPEN,
    SectorState.BLOCKED: BLOCKED,
    SectorState.UNKNOWN: UNKNOWN,
    SectorState.STALE: STALE,
}
"""Of the ring of sectors."""
_BODY: Colour = PATH
_RING = 8
_SPACE = 4
"""Pixels: the ring, and between it and the window."""
_SEAM = 2.0
"""Pixels between two sectors of the ring."""


def side(view: View, cell: int) -> int:
    """Pixels along a side of the picture, with so many for a cell."""
    return (2 * view.window.half + 1) * cell + 2 * (_RING + _SPACE)


def drawn(view: View, decision: Decision, sectors: Sequence[Sector], cell: int) -> Pixels:
    """(side, side, 3) north up; what is masked is tinted. `cell`: pixels for each."""
    half = view.window.half
    size = 2 * half + 1
    cells = np.full((size, size, 3), 255, np.uint8)
    rows, cols = (
        np.rint(axis / view.window.resolution).astype(np.intp) + half
        for axis in (view.window.y, view.window.x)
    )
    cells[rows, cols] = _shades(view, decision)
    inner = np.repeat(np.repeat(cells, cell, axis=0), cell, axis=1)
    margin = _RING + _SPACE
    pixels = np.pad(inner, ((margin, margin), (margin, margin), (0, 0)), constant_values=255)
    pen = _Pen(pixels, view, cell)
    pen.sectors(sectors)
    pen.body()
    pen.ray(decision.goal.bearing, min(decision.goal.distance, view.window.horizon), GOAL)
    if decision.heading is not None:
        pen.ray(decision.heading, view.window.horizon, CHOSEN)
    return pixels[::-1]


def _shades(view: View, decision: Decision) -> Pixels:
    """(n, 3) of each cell of the window: the darker the more certain."""
    grey = 255.0 * (1.0 - view.certainty / MOST)
    shades = np.repeat(np.rint(grey).astype(np.uint8)[:, np.newaxis], 3, axis=1)
    free = view.certainty == 0
    shades[free & (decision.polar.masked | view.shut)[view.window.nearest_sector]] = MASKED
    shades[free & (view.seen_ns == 0)] = UNKNOWN
    return shades


class _Pen:
    """Draws around the robot on a picture whose row 0 is south."""

    def __init__(self, pixels: Pixels, view: View, cell: int) -> None:
        self._pixels = pixels
        self._view = view
        self._metre = cell / view.window.resolution
        """Pixels."""
        self._middle = len(pixels) / 2.0

    def sectors(self, sectors: Sequence[Sector]) -> None:
        """Around the window a ring of their states, and in it an arc where each one's obstacle is nearest."""
        if not sectors:
            return
        places = np.arange(len(self._pixels)) + 0.5 - self._middle
        around, out = np.arctan2(places[:, np.newaxis], places), np.hypot(places[:, np.newaxis], places)
        turns = (around - self._view.robot.yaw) / tau * len(sectors)
        sector = np.rint(turns).astype(np.intp) % len(sectors)
        to_border = (0.5 - np.abs(turns - np.rint(turns))) * tau / len(sectors) * out
        ring = (out >= self._middle - _RING) & (out < self._middle) & (2.0 * to_border > _SEAM)
        states = np.array([STATES[each.state] for each in sectors], np.uint8)
        self._pixels[ring] = states[sector[ring]]
        for each in sectors:
            if each.nearest < self._view.window.horizon:
                middle = self._view.robot.yaw + each.bearing
                along = middle + np.linspace(-0.45, 0.45, 200) * tau / len(sectors)
                self._dots(each.nearest * np.cos(along), each.nearest * np.sin(along), NEAREST)

    def body(self) -> None:
        """The robot's disc, and where it points."""
        around = np.linspace(0.0, tau, 720)
        radius = self._view.window.body.radius
        self._dots(radius * np.cos(around), radius * np.sin(around), _BODY)
        self.ray(self._view.robot.yaw, radius, _BODY)

    def ray(self, bearing: float, length: float, colour: Colour) -> None:
        """A line from the robot."""
        along = np.linspace(0.0, length, 1000)
        self._dots(along * cos(bearing), along * sin(bearing), colour)

    def _dots(self, x: Floats, y: Floats, colour: Colour) -> None:
        """Two pixels wide, at these places (m from the robot)."""
        last = len(self._pixels) - 2
        east, north = self._view.offset
        row = np.clip(np.rint((y + north) * self._metre + self._middle).astype(np.intp) - 1, 0, last)
        col = np.clip(np.rint((x + east) * self._metre + self._middle).astype(np.intp) - 1, 0, last)
        for down in (0, 1):
            for across in (0, 1):
                self._pixels[row + down, col + across] = colour
