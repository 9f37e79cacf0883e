from math import ceil, hypot, inf

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.planning.recollection import Recollection
from echogrid.mapping.planning.terrain import Point, Prices, Terrain, terrain

PRICES = Prices(keep=0.35, shy=0.4, near=2.0, unknown=1.3, squeeze=20.0)


def ground(obstacles: list[Point], ends: tuple[Point, ...] = (), known: bool = True) -> Terrain:
    memory = Recollection()
    memory.cover(0.0, 0.0, 3.0)
    if known:
        memory.belief[:] = -1
    for x, y in obstacles:
        memory.belief[memory.geometry.cell(x, y)] = 1
    return terrain(memory, PRICES, ends)


def weight(land: Terrain, x: float, y: float) -> float:
    return float(land.weights[land.geometry.cell(x, y)])


def test_no_way_leads_nearer_to_an_obstacle_than_is_kept() -> None:
    land = ground([(0.05, 0.05)])
    geometry = land.geometry
    x, y = np.meshgrid(geometry.x_centres, geometry.y_centres)
    near = np.hypot(x - 0.05, y - 0.05) < PRICES.keep
    assert np.array_equal(land.weights == inf, near)


def test_it_is_the_dearer_the_nearer_to_an_obstacle() -> None:
    land = ground([(0.05, 0.05)])
    prices = [weight(land, 0.05 + 0.1 * step, 0.05) for step in range(4, 10)]
    assert prices == sorted(prices, reverse=True)
    assert prices[0] == approx(1.0 + 2.0 * (0.35 / 0.4) ** 2)
    assert prices[-1] == 1.0


def test_what_is_unknown_costs_more_and_may_be_driven() -> None:
    assert weight(ground([], known=False), 1.0, 1.0) == approx(1.3)


def test_around_an_end_that_is_too_near_it_is_dear_but_not_at_the_obstacle() -> None:
    land = ground([(0.05, 0.05)], ends=((0.25, 0.05),))
    assert weight(land, 0.25, 0.05) == 20.0
    assert weight(land, 0.15, 0.05) == inf
    assert weight(land, -0.25, 0.05) == inf


def test_an_end_that_is_far_enough_opens_nothing() -> None:
    assert weight(ground([(0.05, 0.05)], ends=((0.45, 0.05),)), 0.35, 0.05) == inf


def test_a_line_is_open_if_it_keeps_clear() -> None:
    land = ground([(0.05, 0.05)])
    assert not land.is_open((-1.0, 0.05), (1.0, 0.05))
    assert land.is_open((-1.0, 0.55), (1.0, 0.55))


def test_a_line_out_of_a_narrow_place_is_open_and_none_back_into_it() -> None:
    robot = (0.25, 0.05)
    land = ground([(0.05, 0.05), (0.05, 0.75)], ends=(robot,))
    assert land.is_open(robot, (1.0, 0.05))
    assert not land.is_open((1.0, 0.05), (-1.0, 0.05))


def test_the_nearest_cell_is_the_one_over_the_point_if_it_may_be_driven() -> None:
    land = ground([(0.05, 0.05)])
    assert land.nearest((1.02, 1.07)) == land.geometry.cell(1.02, 1.07)
    cell = land.nearest((0.16, 0.06))
    assert cell is not None
    geometry = land.geometry
    x, y = np.meshgrid(geometry.x_centres, geometry.y_centres)
    away = np.where(land.passable, np.hypot(x - 0.16, y - 0.06), inf)
    assert away[cell] == away.min()


points = st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0))


@settings(deadline=None)
@given(st.lists(points, max_size=12), points, points)
def test_a_straight_way_is_open_and_costs_as_its_points_do_one_by_one(
    obstacles: list[Point], here: Point, there: Point
) -> None:
    inside = [(max(min(x, 2.9), -2.9), max(min(y, 2.9), -2.9)) for x, y in obstacles]
    land = ground(inside, (here, there))
    length = hypot(there[0] - here[0], there[1] - here[1])
    count = ceil(2.0 * length / 0.1) + 1
    cells = []
    for share in np.linspace(0.0, 1.0, count + 1).tolist():
        x, y = (start + share * (end - start) for start, end in zip(here, there, strict=True))
        row, col = land.geometry.cell(x, y)
        cells.append((min(max(row, 0), land.geometry.rows - 1), min(max(col, 0), land.geometry.cols - 1)))
    shut = "".join("#" if land.blocked[cell] else "." for cell in cells).strip("#")
    assert land.is_open(here, there) == ("#" not in shut and all(land.passable[cell] for cell in cells))
    if land.is_open(here, there):
        assert land.price(here, there) == approx(length * np.mean([land.weights[cell] for cell in cells]))
