"""A dense fan of rays against segments and circles: the plain way to see what stands in front of a sensor."""

import numpy as np


def hits(world, origin, headings):
    """(rays, walls + cylinders): distance of each surface along each ray, inf for a miss."""
    x, y = origin
    ux, uy = np.cos(headings)[:, None], np.sin(headings)[:, None]
    return np.hstack((_on_segments(world.walls, x, y, ux, uy), _on_circles(world.cylinders, x, y, ux, uy)))


def _on_segments(walls, x, y, ux, uy):
    px, py = walls[:, 0] - x, walls[:, 1] - y
    vx, vy = walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1]
    determinant = vx * uy - vy * ux
    slanted = np.abs(determinant) > 1e-14
    divisor = np.where(slanted, determinant, 1.0)
    distance, share = (vx * py - vy * px) / divisor, (ux * py - uy * px) / divisor
    return np.where(slanted & (distance > 0.0) & (share >= 0.0) & (share <= 1.0), distance, np.inf)


def _on_circles(circles, x, y, ux, uy):
    px, py, radius = circles[:, 0] - x, circles[:, 1] - y, circles[:, 2]
    ahead, aside = px * ux + py * uy, px * uy - py * ux
    half_chord = np.sqrt(np.maximum(radius**2 - aside**2, 0.0))
    return np.where((ahead > 0.0) & (np.abs(aside) <= radius), ahead - half_chord, np.inf)


def nearest_hit(world, origin, heading):
    """Distance of the first surface along one ray."""
    return float(hits(world, origin, np.array([heading])).min(initial=np.inf))


def beam(axis, half_width, step):
    """Headings from one side of a beam to the other."""
    count = int(half_width / step)
    return axis + step * np.arange(-count, count + 1)


def shortest_way(world, place):
    """Distance to the nearest surface in any direction."""
    x, y = place
    ways = [abs(np.hypot(x - cx, y - cy) - radius) for cx, cy, radius in world.cylinders]
    for ax, ay, bx, by in world.walls:
        span = np.array((bx - ax, by - ay))
        share = np.clip(np.dot((x - ax, y - ay), span) / np.dot(span, span), 0.0, 1.0)
        ways.append(np.hypot(x - ax - share * span[0], y - ay - share * span[1]))
    return min(ways)
