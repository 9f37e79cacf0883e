from dataclasses import replace
from math import hypot, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.long_term_map import MapImage
from echogrid.mapping.pose import Pose
from echogrid.mapping.steering.decision import Why
from echogrid.mapping.steering.goal import towards
from echogrid.mapping.virtual_sensor import SectorState
from echogrid.runtime.comparison_scenes import scenes
from echogrid.runtime.comparison_steering import AHEAD_M, TRUTH, Choice, Helm, Place, places, steered
from echogrid.runtime.comparison_tables import Table, steering
from echogrid.runtime.config import Config

Poses = list[tuple[int, Pose]]

SIZE = 0.1
GEOMETRY = GridGeometry(SIZE, -3.0, -3.0, 60, 160)
"""From -3 to 13 m east, from -3 to 3 m north."""
HERE = Place(Pose(0.0, 0.0, 0.0), 0.3, towards(Pose(), 1.5, 0.0))


def floor(*walls: tuple[float, float, float, float]) -> MapImage:
    """All free, but for boxes: west, south, east, north (m)."""
    p = np.full(GEOMETRY.shape, 0.02, np.float32)
    for west, south, east, north in walls:
        p[GEOMETRY.window(west, south, east, north)] = 0.98
    return MapImage(GEOMETRY, p, np.zeros(GEOMETRY.shape, np.bool_))


def drive(length: float, speed: float = 0.5) -> Poses:
    """Straight east from (0, 0), a pose each 0.1 s."""
    return [
        (100_000_000 * step, Pose(0.1 * speed * step, 0.0)) for step in range(round(length / speed * 10) + 1)
    ]


def decided(image: MapImage, place: Place = HERE) -> Choice:
    return Helm(Config(), image.geometry.resolution).choice(image, place)


OPEN = floor()
BLOCK = floor((0.9, -0.3, 1.2, 0.2))
"""Something before the robot, a little to the right."""
SHUT = floor((0.6, -3.0, 0.8, 3.0), (-0.8, -3.0, -0.6, 3.0), (-3.0, 0.6, 3.0, 0.8), (-3.0, -0.8, 3.0, -0.6))
"""A cell of 1.2 m."""


def test_places_lie_along_the_way_each_with_a_goal_further_on() -> None:
    found = places(drive(5.0))
    np.testing.assert_allclose([place.pose.x for place in found], np.arange(0.0, 3.5, 0.5), atol=1e-6)
    np.testing.assert_allclose([place.goal.distance for place in found], AHEAD_M, atol=0.051)
    np.testing.assert_allclose([place.speed for place in found], 0.5)
    assert {place.goal.bearing for place in found} == {0.0}


@pytest.mark.parametrize("length", [0.0, 1.4])
def test_a_way_too_short_for_a_goal_has_no_places(length: float) -> None:
    assert places(drive(length)) == []


def test_where_the_robot_jumps_or_turns_back_there_is_no_place() -> None:
    there = drive(4.0)
    end_ns, end = there[-1]
    back = [(end_ns + stamp_ns + 1, replace(end, x=end.x - pose.x)) for stamp_ns, pose in drive(4.0)]
    away = [(end_ns + stamp_ns + 1, replace(pose, x=pose.x + 1e9)) for stamp_ns, pose in drive(4.0)]
    turned, jumped = (places(there + more) for more in (back, away))
    assert all(0.3 < place.goal.distance < 3.0 for place in turned + jumped)
    assert {place.goal.bearing for place in turned} == {0.0, pi}
    assert max(place.pose.x for place in jumped) > 1e9
    assert len(jumped) < 20


def test_a_small_local_grid_is_large_enough_to_steer_by() -> None:
    small = replace(Config(), local=replace(Config().local, size_m=0.6))
    assert Helm(small, SIZE).choice(OPEN, HERE).decision.why is Why.TARGET


def test_on_a_free_floor_it_goes_straight_to_the_goal_and_all_sectors_are_clear() -> None:
    choice = decided(OPEN)
    assert choice.decision.why is Why.TARGET
    assert {sector.state for sector in choice.sectors} == {SectorState.CLEAR}


def test_it_goes_around_what_stands_in_the_way_and_the_sensor_tells_of_it() -> None:
    choice = decided(BLOCK)
    assert choice.decision.why is Why.AROUND
    assert (choice.decision.heading or 0.0) > 0.0
    assert choice.sectors[0].state is SectorState.BLOCKED
    assert choice.sectors[0].nearest == pytest.approx(0.95, abs=0.06)


def test_what_is_unknown_or_beyond_the_map_is_unknown_to_the_sensor() -> None:
    nothing = replace(OPEN, unknown=np.ones(GEOMETRY.shape, np.bool_))
    beyond = replace(HERE, pose=Pose(50.0, 50.0))
    for choice in (decided(nothing), decided(OPEN, beyond)):
        assert {sector.state for sector in choice.sectors} == {SectorState.UNKNOWN}


def test_at_the_border_half_of_the_surroundings_is_known() -> None:
    choice = decided(OPEN, replace(HERE, pose=Pose(-3.0, 0.0)))
    states = [sector.state for sector in choice.sectors]
    assert states[0] is SectorState.CLEAR
    assert states[8] is SectorState.UNKNOWN


@given(st.integers(-500, 500), st.integers(-500, 500), st.floats(-0.099, 0.099))
def test_a_decision_does_not_depend_on_where_the_map_s_frame_is(cols: int, rows: int, odd: float) -> None:
    east, north = SIZE * cols + odd, SIZE * rows - odd
    moved = replace(BLOCK, geometry=replace(GEOMETRY, x=GEOMETRY.x + east, y=GEOMETRY.y + north))
    here = Pose(0.031 + east, -0.022 + north)
    there = decided(moved, replace(HERE, pose=here))
    same = decided(BLOCK, replace(HERE, pose=Pose(0.031, -0.022)))
    assert there.decision.heading == same.decision.heading
    assert [sector.nearest for sector in there.sectors] == pytest.approx(
        [each.nearest for each in same.sectors]
    )


@given(st.floats(0.1, 0.9))
def test_a_heading_is_free_in_truth_as_far_as_the_true_map_says(north: float) -> None:
    walls = floor((0.8, north, 1.0, 3.0))
    outcomes = steered(Config(), drive(3.0), {TRUTH: walls, "map": OPEN}).outcomes
    for true, blind in zip(outcomes[TRUTH], outcomes["map"], strict=True):
        assert true.free == true.promised
        assert blind.promised == pytest.approx(1.6)
        assert blind.free is not None
        assert blind.free <= 1.6


def row(table: Table, name: str) -> dict[str, str]:
    """By the column's title."""
    found = next(each for each in table.rows if each[0] == name)
    return dict(zip(table.header, found, strict=True))


def test_the_table_tells_of_needless_stops_and_of_walls_not_seen() -> None:
    wall = floor((4.0, -3.0, 4.2, 3.0))
    found = steered(Config(), drive(5.0), {TRUTH: wall, "blind": OPEN, "timid": SHUT, "good": wall})
    table = steering(found)
    assert [each[0] for each in table.rows] == [TRUTH, "blind", "timid", "good"]
    assert row(table, "good") | {"map": TRUTH} == row(table, TRUTH)
    assert row(table, "good")["off the true choice, deg"] == "0"
    assert row(table, "good")["walls not seen"] == "0%"
    assert row(table, "blind")["no way"] == "0%"
    near = [each for each in found.outcomes["blind"] if each.free is not None and each.free < 1.3]
    assert row(table, "blind")["walls not seen"] == f"{len(near) / len(found.places):.0%}" != "0%"
    assert row(table, "blind")["least"] == f"{min(each.free or 0.0 for each in near):.2f}"
    stops = sum(each.heading is None for each in found.outcomes["timid"])
    assert row(table, "timid")["no way"] == f"{stops / len(found.places):.0%}" != "0%"


def test_a_map_with_no_way_anywhere_has_no_figures_of_headings() -> None:
    told = row(steering(steered(Config(), drive(2.0), {TRUTH: OPEN, "timid": SHUT})), "timid")
    assert told.pop("no way") == "100%"
    assert told.pop("walls not seen") == "0%"
    assert set(told.values()) == {"timid", "-"}


def test_without_a_truth_the_table_has_what_needs_none() -> None:
    table = steering(steered(Config(), drive(3.0), {"blind": OPEN, "good": BLOCK}))
    assert table.header == ("map", "no way", "off the goal, deg", "free by the map, m")
    assert "not seen" not in " ".join(table.notes)


def test_shown_are_the_places_where_the_theories_differ_most() -> None:
    poses = drive(9.0)
    block = floor((5.9, -0.3, 6.2, 0.2))
    found = steered(Config(), poses, {"one": OPEN, "other": block, TRUTH: OPEN})
    odds = [
        pi if other.heading is None else abs((one.heading or 0.0) - other.heading)
        for one, other in zip(found.outcomes["one"], found.outcomes["other"], strict=True)
    ]
    first, second = found.scenes
    assert found.places[int(np.argmax(odds))] in (first.place, second.place)
    assert hypot(first.place.pose.x - second.place.pose.x, first.place.pose.y - second.place.pose.y) >= 3.0
    assert first.place.pose.x < second.place.pose.x


def test_a_map_of_large_cells_is_not_steered_by() -> None:
    coarse = MapImage(
        GridGeometry(0.5, 0.0, 0.0, 9, 9), np.full((9, 9), 0.5, np.float32), np.ones((9, 9), bool)
    )
    found = steered(Config(), drive(5.0), {"one": coarse})
    assert (found.places, found.scenes, list(scenes(found))) == ((), (), [])


def test_a_scene_tells_what_is_decided_and_what_becomes_of_it() -> None:
    maps = {TRUTH: BLOCK, "blind": OPEN, "timid": SHUT, "good": BLOCK}
    (gallery, *_) = scenes(steered(Config(), drive(2.0), maps))
    told = {picture.name: picture.caption for picture in gallery.pictures}
    assert list(told) == list(maps)
    assert told["blind"].startswith("straight to the goal, in line with the goal; 0.")
    assert "m free in truth, at least 1.60 m free by the map. Sectors: 16 of 16 clear." in told["blind"]
    assert told["timid"].startswith(
        "every way is blocked: it stops. Sectors: 0 of 16 clear, nearest obstacle 0.6"
    )
    assert told["good"].startswith("around an obstacle, ")
    assert " deg left of the goal; " in told["good"]
    assert gallery.title == "steering by each map, 1: at 0.0, 0.0 m"
    assert len({picture.pixels.shape for picture in gallery.pictures}) == 1
