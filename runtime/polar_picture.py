"""The polar histogram of a decision as a picture: bars, thresholds, the goal's sector and the chosen one."""

from math import inf, sqrt

import numpy as np

from echogrid.mapping.steering.decision import Decision
from echogrid.mapping.steering.obstacles import View
from echogrid.mapping.steering.sectors import to_sectors
from echogrid.runtime.steering_window import BLOCKED, CHOSEN, GOAL, MASKED, OPEN, Colour, Pixels

THRESHOLD: Colour = (150, 60, 160)
_SHOWN = 2.0
"""So many times the upper threshold is shown, at least."""


def drawn(view: View, decision: Decision, rows: int, bar: int) -> Pixels:
    """(rows, sectors * bar, 3) straight ahead in the middle, left to the left. A bar for each sector, as high
    as the root of its density."""
    polar, n = decision.polar, view.window.sectors
    pixels = np.full((rows, n * bar, 3), 255, np.uint8)
    top = max(float(polar.density.max()), _SHOWN * polar.high if polar.high < inf else 1e-9)
    heights = np.rint(np.sqrt(polar.density / top) * rows).astype(np.intp)
    for sector in range(n):
        place = _place(view, sector, bar)
        across = slice(place, place + bar - 1)
        if polar.masked[sector] or view.shut[sector]:
            pixels[:, across] = MASKED
        pixels[: heights[sector], across] = BLOCKED if polar.blocked[sector] else OPEN
    for threshold in (polar.low, polar.high):
        if threshold < inf:
            level = round(sqrt(threshold / top) * rows)
            pixels[max(level - 2, 0) : level] = THRESHOLD
    _mark(pixels, view, decision.goal.bearing, bar, GOAL)
    if decision.heading is not None:
        _mark(pixels, view, decision.heading, bar, CHOSEN)
    return pixels[::-1]


def _mark(pixels: Pixels, view: View, bearing: float, bar: int, colour: Colour) -> None:
    middle = _place(view, to_sectors(bearing, view.window.sectors), bar) + bar // 2
    pixels[:, max(middle - 1, 0) : middle + 2] = colour


def _place(view: View, sector: float, bar: int) -> int:
    """The first column of pixels of a sector; that of straight ahead is in the middle."""
    n = view.window.sectors
    left = (sector - to_sectors(view.robot.yaw, n) + n / 2.0) % n
    return int((n - left) * bar) % (n * bar - bar + 1)
