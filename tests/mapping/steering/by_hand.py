"""The histograms, cell by cell and sector by sector, from the equations."""

from math import asin, atan2, degrees, floor, hypot, pi, sqrt, tau

from .scenes import BODY, RESOLUTION, Cell

HALF = 16
KEEP = BODY.radius + BODY.margin + RESOLUTION / sqrt(2.0)
LEAST = 6
SECTORS = 72


def obstacles(world: list[Cell]) -> list[tuple[int, int, int]]:
    """Rows, columns and certainties of the obstacles in the window; of cells given twice the last counts."""
    painted = {(row, col): milli for row, col, milli in world}
    return [
        (row, col, min(max(milli, 0) * 15 // 2000, 15))
        for (row, col), milli in painted.items()
        if row**2 + col**2 <= HALF**2 and min(max(milli, 0) * 15 // 2000, 15) >= LEAST
    ]


def vfh(world: list[Cell]) -> list[float]:
    """The smoothed densities."""
    raw = [0.0] * SECTORS
    for row, col, certainty in obstacles(world):
        sector = floor(degrees(atan2(row, col)) / 5.0 + 1e-9) % SECTORS
        raw[sector] += certainty**2 * (sqrt(2.0) * HALF - hypot(row, col))
    return [sum((6 - abs(i)) * raw[(k + i) % SECTORS] for i in range(-5, 6)) / 11.0 for k in range(SECTORS)]


def vfh_plus(world: list[Cell]) -> list[float]:
    """The primary histogram."""
    primary = [0.0] * SECTORS
    for row, col, certainty in obstacles(world):
        distance = hypot(row, col)
        gamma = asin(KEEP / (distance * RESOLUTION)) if distance * RESOLUTION > KEEP else pi / 2.0
        for k in range(SECTORS):
            off = abs((k * tau / SECTORS - atan2(row, col) + pi) % tau - pi)
            if off <= gamma + 1e-9:
                primary[k] += certainty**2 * (HALF**2 + 1 - row**2 - col**2)
    return primary


def vff(world: list[Cell], repulsion: float) -> tuple[float, float]:
    """The sum of the pushes."""
    x = y = 0.0
    for row, col, certainty in obstacles(world):
        distance = hypot(row, col) * RESOLUTION
        x -= repulsion * certainty / distance**2 * (col * RESOLUTION / distance)
        y -= repulsion * certainty / distance**2 * (row * RESOLUTION / distance)
    return x, y
