"""Worlds made by chance, to learn from: none of them is among those in which anything is judged."""

from collections.abc import Callable, Iterator
from heapq import heappop, heappush
from itertools import pairwise
from math import hypot
from random import Random

import numpy as np

from echogrid.emulation.floor_plan import FloorPlan, Rectangle
from echogrid.emulation.motion import Tour
from echogrid.emulation.vista import Point
from echogrid.emulation.walker import WALKING_SPEED, Walker
from echogrid.emulation.world import World
from echogrid.emulation.worlds.furnishing import Box, Furnishing, Post
from echogrid.emulation.worlds.venue import Venue

LEAST_M = 60.0
"""A round is at least so long."""
_CLEAR_M = 0.45
"""The robot keeps so far from everything."""
_PLACES = 220
"""Way points to choose from."""
_SHORTEST_M, _LONGEST_M = 0.3, 4.0
_STEPS, _GIVE_M = 17, 0.05
"""A straight line is looked at in so many places; there it may be so much nearer."""
_CORRIDOR_M, _DOOR_M, _WALL_M = 1.8, 0.9, 0.2

Links = list[list[tuple[int, float]]]
"""For each way point the others that are in reach on a straight line, and how far they are, m."""


def school(seed: int) -> Venue:
    """A venue: halls with crates, floors of rooms and halls with people take turns."""
    random = Random(f"school {seed}")
    make: Callable[[Random], World] = (_hall, _rooms, _crowd)[seed % 3]
    while True:
        world = make(random)
        if tour := _round(world, random):
            return Venue(world, tour)


def _hall(random: Random) -> World:
    """Crates at all angles, and posts."""
    width, depth = random.uniform(8.0, 15.0), random.uniform(7.0, 11.0)
    plan = FloorPlan(((0.0, 0.0, width, depth),), tuple(_cupboards(random, width, depth)))
    boxes = tuple(_boxes(random, width, depth, random.randint(3, 11)))
    posts = tuple(_posts(random, width, depth, random.randint(2, 9), 0.03, 0.3))
    return Furnishing(boxes=boxes, posts=posts).world("hall", _roughened(plan, random))


def _rooms(random: Random) -> World:
    """Rooms on both sides of a corridor, with doors."""
    widths = [random.uniform(3.0, 6.0) for _ in range(random.randint(2, 4))]
    length, top = sum(widths) + _WALL_M * (len(widths) - 1), _CORRIDOR_M + _WALL_M
    floors: list[Rectangle] = [(0.0, 0.0, length, _CORRIDOR_M)]
    furniture: list[Rectangle] = []
    west = 0.0
    for width in widths:
        for low, high in (
            (top, top + random.uniform(3.0, 4.5)),
            (-_WALL_M - random.uniform(3.0, 4.5), -_WALL_M),
        ):
            floors.append((west, low, west + width, high))
            door = west + random.uniform(0.3, width - _DOOR_M - 0.3)
            gap = (_CORRIDOR_M, top) if low > 0.0 else (-_WALL_M, 0.0)
            floors.append((door, gap[0], door + _DOOR_M, gap[1]))
            if random.random() < 0.7:
                x, y = random.uniform(west + 0.2, west + width - 1.2), random.uniform(low + 0.9, high - 1.5)
                furniture.append((x, y, x + random.uniform(0.4, 1.0), y + random.uniform(0.3, 0.7)))
        west += width + _WALL_M
    bottom = min(floor[1] for floor in floors)
    height = max(floor[3] for floor in floors)
    posts = tuple(
        Post(post.x, post.y + bottom, post.radius, post.softness)
        for post in _posts(random, length, height - bottom, random.randint(2, 6), 0.03, 0.2)
    )
    return Furnishing(posts=posts).world("rooms", _roughened(FloorPlan(floors, furniture), random))


def _crowd(random: Random) -> World:
    """Pillars, a few boxes, and people who walk about."""
    width, depth = random.uniform(9.0, 17.0), random.uniform(8.0, 12.0)
    plan = FloorPlan(((0.0, 0.0, width, depth),), tuple(_cupboards(random, width, depth)))
    posts = tuple(_posts(random, width, depth, random.randint(2, 8), 0.1, 0.3))
    boxes = tuple(_boxes(random, width, depth, random.randint(1, 5)))
    walkers = tuple(_walker(random, width, depth) for _ in range(random.randint(2, 6)))
    furnishing = Furnishing(boxes=boxes, posts=posts, walkers=walkers)
    return furnishing.world("crowd", _roughened(plan, random))


def _roughened(plan: FloorPlan, random: Random) -> FloorPlan:
    """The plan with some of its walls rough, and some furniture soft."""
    spots = [
        (x - 1.0, y - 1.0, x + random.uniform(1.0, 3.0), y + random.uniform(1.0, 3.0))
        for x, y, _, _ in random.sample(list(plan.floors), min(len(plan.floors), 2))
    ]
    soft = [(*each, random.uniform(6.0, 13.0)) for each in plan.furniture if random.random() < 0.4]
    return FloorPlan(plan.floors, plan.furniture, spots, soft)


def _cupboards(random: Random, width: float, depth: float) -> Iterator[Rectangle]:
    """Upright things along the walls."""
    for _ in range(random.randint(1, 4)):
        along, out = random.uniform(0.5, 2.5), random.uniform(0.3, 0.8)
        x, y = random.uniform(0.2, width - along - 0.2), random.uniform(0.2, depth - along - 0.2)
        yield random.choice(
            (
                (x, 0.0, x + along, out),
                (x, depth - out, x + along, depth),
                (0.0, y, out, y + along),
                (width - out, y, width, y + along),
            )
        )


def _boxes(random: Random, width: float, depth: float, number: int) -> Iterator[Box]:
    kept: list[Box] = []
    for _ in range(20 * number):
        x, y = random.uniform(1.2, width - 1.2), random.uniform(1.2, depth - 1.2)
        if len(kept) < number and all(hypot(x - box.x, y - box.y) > 2.4 for box in kept):
            size = random.uniform(0.5, 1.8), random.uniform(0.4, 1.2)
            softness = random.choice((0.0, 0.0, 0.0, 12.0))
            kept.append(Box(x, y, *size, random.uniform(-90.0, 90.0), random.random() < 0.2, softness))
    yield from kept


def _posts(
    random: Random, width: float, depth: float, number: int, least: float, most: float
) -> Iterator[Post]:
    for _ in range(number):
        x, y = random.uniform(0.4, width - 0.4), random.uniform(0.4, depth - 0.4)
        yield Post(x, y, random.uniform(least, most), random.choice((0.0, 0.0, 10.0)))


def _walker(random: Random, width: float, depth: float) -> Walker:
    places = [
        (random.uniform(0.5, width - 0.5), random.uniform(0.5, depth - 0.5))
        for _ in range(random.randint(2, 4))
    ]
    speed = random.uniform(0.6, 1.1) * WALKING_SPEED
    return Walker(places, random.uniform(0.0, 20.0), speed, random.uniform(0.2, 0.25), random.uniform(10, 15))


def _round(world: World, random: Random) -> Tour | None:
    """A way that leads back to where it began; None where there is no such way of that length."""
    places = _places(world, random)
    links = _links(world, places)
    start = max(range(len(places)), key=lambda place: len(links[place]))
    way, length = [start], 0.0
    seen = np.full(len(places), np.inf)
    while length < LEAST_M:
        here = way[-1]
        seen = np.minimum(seen, [hypot(x - places[here][0], y - places[here][1]) for x, y in places])
        goal = int(np.argmax(np.where(np.isfinite(seen), seen, 0.0) + [random.random() for _ in places]))
        leg = _path(links, here, goal)
        if len(leg) < 2:
            seen[goal] = 0.0
            if not np.any(seen > 1.0):
                seen[:] = random.random() * 10.0
            if not links[here]:
                return None
            leg = [here, random.choice(links[here])[0]]
        way += leg[1:]
        length += _length(places, leg)
    way += _path(links, way[-1], start)[1:-1]
    spins = frozenset(index for index in range(len(way)) if random.random() < 0.1)
    return Tour([places[place] for place in way], spins)


def _places(world: World, random: Random) -> list[Point]:
    """Points that are clear of everything, with the floor around them."""
    west, south = world.walls[:, [0, 1]].min(axis=0)
    east, north = world.walls[:, [2, 3]].max(axis=0)
    tries = [(random.uniform(west, east), random.uniform(south, north)) for _ in range(6 * _PLACES)]
    clear = world.surface_distance(np.array(tries)) > _CLEAR_M
    inside = [place for place, free in zip(tries, clear, strict=True) if free]
    return inside[:_PLACES]


def _links(world: World, places: list[Point]) -> Links:
    links: Links = [[] for _ in places]
    points = np.array(places).reshape(-1, 2)
    along = np.linspace(0.0, 1.0, _STEPS)[:, np.newaxis]
    for one, start in enumerate(points):
        ways = points[one + 1 :] - start
        far = np.hypot(ways[:, 0], ways[:, 1])
        near = np.flatnonzero((far > _SHORTEST_M) & (far < _LONGEST_M))
        if not len(near):
            continue
        on_the_way = start + along * ways[near][:, np.newaxis]
        distances = world.surface_distance(on_the_way.reshape(-1, 2)).reshape(len(near), _STEPS)
        for other in near[distances.min(axis=1) > _CLEAR_M - _GIVE_M]:
            links[one].append((one + 1 + int(other), float(far[other])))
            links[one + 1 + int(other)].append((one, float(far[other])))
    return links


def _path(links: Links, start: int, goal: int) -> list[int]:
    """The shortest path (Dijkstra); only the start if there is none."""
    queue: list[tuple[float, int, tuple[int, ...]]] = [(0.0, start, ())]
    done: set[int] = set()
    while queue:
        far, place, before = heappop(queue)
        if place == goal:
            return [*before, place]
        if place not in done:
            done.add(place)
            for following, step in links[place]:
                heappush(queue, (far + step, following, (*before, place)))
    return [start]


def _length(places: list[Point], way: list[int]) -> float:
    return sum(hypot(places[b][0] - places[a][0], places[b][1] - places[a][1]) for a, b in pairwise(way))
