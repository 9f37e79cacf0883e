from math import hypot, inf

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.planning.recollection import Recollection
from echogrid.mapping.planning.route import Route, found
from echogrid.mapping.planning.terrain import Point, Prices, Terrain, terrain

PRICES = Prices(keep=0.3, shy=0.4)
FAR_SIDE = (1.42, 0.03)
spots = st.tuples(st.floats(-1.4, 1.4), st.floats(-1.4, 1.4))


def ground(obstacles: list[Point], ends: tuple[Point, ...] = ()) -> Terrain:
    memory = Recollection()
    memory.cover(0.0, 0.0, 1.5)
    memory.belief[:] = -1
    for x, y in obstacles:
        memory.belief[memory.geometry.cell(x, y)] = 1
    return terrain(memory, PRICES, ends)


def wall(south: float, north: float) -> list[Point]:
    return [(0.05, float(y)) for y in np.arange(south, north, 0.1) + 0.05]


@settings(deadline=None, max_examples=60)
@given(st.lists(spots, max_size=5), spots, spots)
def test_no_part_of_a_way_is_shut_and_it_leads_from_end_to_end(
    obstacles: list[Point], here: Point, goal: Point
) -> None:
    land = ground(obstacles, (here, goal))
    way = found(land, here, goal)
    if way is None or not (
        land.passable[land.geometry.cell(*here)] and land.passable[land.geometry.cell(*goal)]
    ):
        return
    assert tuple(way.points[0]) == here
    assert way.end == goal
    assert np.hypot(*np.diff(way.points, axis=0).T).max() <= 0.15
    assert not way.is_shut(land, here)
    assert way.price(land) < inf


@settings(deadline=None, max_examples=60)
@given(spots, spots)
def test_in_the_open_it_is_straight(here: Point, goal: Point) -> None:
    way = found(ground([]), here, goal)
    assert way is not None
    assert way.lengths[0] == approx(hypot(goal[0] - here[0], goal[1] - here[1]))


def test_the_carrot_is_never_behind_what_is_enlarged() -> None:
    land, here = ground(wall(-0.8, 0.8)), (-1.4, 0.0)
    way = found(land, here, FAR_SIDE)
    assert way is not None
    for x, y in way.points.tolist():
        (to_x, to_y), length = way.carrot(land, (x, y), 1.5)
        assert land.is_open((x, y), (to_x, to_y)) or hypot(to_x - x, to_y - y) < 0.15
        assert length >= hypot(FAR_SIDE[0] - x, FAR_SIDE[1] - y) - 1e-9


def test_a_wall_across_it_shuts_it_but_not_once_it_is_passed() -> None:
    way = found(ground([]), (-1.4, 0.0), FAR_SIDE)
    assert way is not None
    shut = ground(wall(-0.8, 0.8))
    assert way.is_shut(shut, (-1.4, 0.0))
    assert way.price(shut) == inf
    assert not way.is_shut(shut, (0.7, 0.0))


def test_where_a_wall_parts_the_ground_there_is_no_way() -> None:
    assert found(ground(wall(-3.2, 3.2)), (-1.0, 0.0), FAR_SIDE) is None


def test_a_way_is_beside_another_if_no_point_is_far_from_it() -> None:
    one = Route(np.array([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]))
    assert Route(np.array([(0.0, 0.3), (1.0, 0.4)])).beside(one, 0.5)
    assert not Route(np.array([(0.0, 0.3), (1.0, 0.6)])).beside(one, 0.5)


@given(
    st.lists(spots, min_size=2, max_size=12),
    spots,
    st.floats(0.0, 3.0),
)
def test_ahead_are_the_points_after_the_nearest_one_for_so_much_way(
    points: list[Point], here: Point, most: float
) -> None:
    way = Route(np.array(points))
    ahead = way.ahead(here, most).tolist()
    first = min(way.after(here) + 1, len(points) - 1)
    assert ahead == way.points[first : first + len(ahead)].tolist()
    assert len(ahead) >= 1
    far = float(np.hypot(*np.diff(np.array(ahead), axis=0).T).sum())
    assert far <= most + 1e-9
    if first + len(ahead) < len(points):
        after = points[first + len(ahead)]
        assert far + hypot(after[0] - ahead[-1][0], after[1] - ahead[-1][1]) > most - 1e-9


def test_ahead_of_a_robot_beside_the_way_lie_its_next_points() -> None:
    way = Route(np.array([(0.1 * n, 0.0) for n in range(11)]))
    assert way.ahead((0.42, 0.2), 0.25)[:, 0].tolist() == approx([0.5, 0.6, 0.7])
    assert way.ahead((3.0, 0.0), 0.25).tolist() == [approx([1.0, 0.0])]
