import tracemalloc
from math import cos, pi, radians, sin

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.calibrated import CalibratedGrid, shipped
from echogrid.mapping.evidence import CellEvidence
from echogrid.mapping.evidence_features import around, context_features, own_features
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sounding import Sounding

from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-3.0, -3.0, 3.0, 3.0, 0.1)
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.1, 5.0)

LINES = (np.eye(25), np.eye(25)[::-1], np.ones((25, 1)) * (np.arange(25) == 12))
"""Through the middle."""

soundings = st.builds(Sounding, poses(3.0), rangers(), st.none() | st.floats(0.0, 4.0), st.just(0.12))


def past_a_wall() -> list[Sounding]:
    """A robot that drives along a wall at y = 1, and hears it from the side; nothing answers from ahead."""
    aside = [Sounding(Pose(x, 0.0, pi / 2.0), SONAR, 1.0, 0.12) for x in np.arange(-2.0, 2.0, 0.11)]
    ahead = [Sounding(Pose(x, 0.0, 0.0), SONAR, None, 0.12) for x in np.arange(-2.0, 0.0, 0.11)]
    return [*aside, *ahead]


def grid(pings: list[Sounding]) -> CalibratedGrid:
    made = CalibratedGrid(GEOMETRY)
    for ping in pings:
        made.update(ping)
    return made


@settings(deadline=None, max_examples=30)
@given(st.lists(soundings, max_size=8))
def test_probabilities_are_such_and_half_where_nobody_spoke(pings: list[Sounding]) -> None:
    made = grid(pings)
    occupancy = made.occupancy()
    assert np.all(np.isfinite(occupancy))
    assert np.all((occupancy >= 0.0) & (occupancy <= 1.0))
    assert np.all(occupancy[made.unknown()] == 0.5)


def test_a_wall_is_occupied_and_the_way_along_it_free() -> None:
    made = grid(past_a_wall())
    occupancy = made.occupancy()
    wall = [occupancy[GEOMETRY.cell(x, 1.0)] for x in np.arange(-1.5, 1.5, 0.1)]
    free = [occupancy[GEOMETRY.cell(x, 0.5)] for x in np.arange(-1.5, 1.5, 0.1)]
    assert np.median(wall) > 0.8
    assert max(free) < 0.1
    assert made.unknown()[GEOMETRY.cell(0.0, 2.0)]


@settings(deadline=None, max_examples=30)
@given(st.lists(soundings, max_size=8))
def test_a_larger_map_says_the_same_of_the_same_place(pings: list[Sounding]) -> None:
    around = CalibratedGrid(GridGeometry.covering(-9.0, -9.0, 9.0, 9.0, 0.1))
    middle = CalibratedGrid(GridGeometry.covering(-8.0, -8.0, 8.0, 8.0, 0.1))
    for ping in pings:
        around.update(ping)
        middle.update(ping)
    inside = slice(10, -10), slice(10, -10)
    np.testing.assert_allclose(around.occupancy()[inside], middle.occupancy(), atol=1e-6)
    np.testing.assert_array_equal(around.unknown()[inside], middle.unknown())


def test_what_was_never_heard_costs_little() -> None:
    made = CalibratedGrid(GridGeometry.covering(-50.0, -50.0, 50.0, 50.0, 0.1))
    for ping in past_a_wall():
        made.update(ping)
    tracemalloc.start()
    made.occupancy()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 50 * made.geometry.rows * made.geometry.cols


def test_silence_alone_makes_nothing_known() -> None:
    made = grid([Sounding(Pose(), SONAR, None, 0.12)])
    assert made.unknown().all()
    assert np.all(made.occupancy() == 0.5)


def test_two_hundred_pings_from_one_spot_move_a_cell_no_more_than_three_from_three_spots() -> None:
    target = (1.0, 0.0)
    spots = [(cos(a), sin(a)) for a in (0.0, 0.7, -0.7)]
    seats = [Pose(target[0] - x, target[1] - y, a) for (x, y), a in zip(spots, (0.0, 0.7, -0.7), strict=True)]
    three = grid([Sounding(seat, SONAR, 1.0, 0.12) for seat in seats])
    stubborn = grid([Sounding(seats[0], SONAR, 1.0, 0.12)] * 200)
    cell = GEOMETRY.cell(*target)
    assert abs(stubborn.occupancy()[cell] - 0.5) <= abs(three.occupancy()[cell] - 0.5)


def test_the_order_of_two_pings_of_different_places_does_not_matter() -> None:
    one = Sounding(Pose(-2.5, -2.5, 0.0), SONAR, 1.0, 0.12)
    other = Sounding(Pose(2.5, 2.5, pi), SONAR, 1.0, 0.12)
    assert np.array_equal(grid([one, other]).occupancy(), grid([other, one]).occupancy())


def test_a_wider_grid_says_the_same() -> None:
    wide = CalibratedGrid(GridGeometry.covering(-6.0, -7.0, 6.0, 5.0, 0.1))
    for ping in past_a_wall():
        wide.update(ping)
    row, col = wide.geometry.cell(GEOMETRY.x_centres[0], GEOMETRY.y_centres[0])
    inner = wide.occupancy()[row : row + GEOMETRY.rows, col : col + GEOMETRY.cols]
    assert inner == approx(grid(past_a_wall()).occupancy(), abs=1e-5)


def test_a_twin_goes_its_own_way() -> None:
    made = grid(past_a_wall())
    twin, before = made.copy(), made.occupancy()
    twin.update(Sounding(Pose(0.0, 0.0, -pi / 2.0), SONAR, 1.0, 0.12))
    assert np.array_equal(made.occupancy(), before)
    assert not np.array_equal(twin.unknown(), made.unknown())


def test_the_shipped_networks_know_as_many_features_as_there_are() -> None:
    features = own_features(CellEvidence(GEOMETRY).statistics, GEOMETRY.resolution)
    context = context_features(np.zeros(GEOMETRY.shape), GEOMETRY.resolution)
    assert len(shipped().own.mean) == features.shape[-1]
    assert len(shipped().context.mean) == features.shape[-1] + context.shape[-1]
    assert len(shipped().again.mean) == len(shipped().context.mean)


@given(st.integers(0, 3))
def test_the_sum_around_is_that_of_the_square(reach: int) -> None:
    values = np.random.default_rng(reach).random((7, 9))
    padded = np.pad(values, reach)
    side = 2 * reach + 1
    by_hand = [[padded[r : r + side, c : c + side].sum() for c in range(9)] for r in range(7)]
    assert around(values, reach) == approx(np.array(by_hand))


def test_a_line_goes_on_to_both_sides_and_ends_across_whatever_its_direction() -> None:
    for line in LINES:
        surer, other, best, second, *across = context_features(line, 0.1)[12, 12, 4:10]
        assert (surer, other, best) == approx((1.0, 1.0, 1.0))
        assert second < 0.5
        assert across == [0.0, 0.0]


def test_where_a_line_ends_one_side_is_not_sure() -> None:
    for line in LINES:
        half = line * (np.add.outer(np.arange(25), np.arange(25) * 0.5) >= 18.0)
        assert context_features(half, 0.1)[12, 12, 4:6] == approx([1, 0])


def test_what_a_wall_claims_lies_along_it_and_not_across() -> None:
    evidence = CellEvidence(GEOMETRY)
    for ping in past_a_wall():
        evidence.add(ping)
    along, across = own_features(evidence.statistics, 0.1)[..., -4:-2][GEOMETRY.cell(0.0, 1.0)]
    assert along > 1.0
    assert across == 0.0


def test_with_smaller_cells_a_wall_is_as_sure_as_with_usual_ones() -> None:
    fine = CalibratedGrid(GridGeometry.covering(-3.0, -3.0, 3.0, 3.0, 0.05))
    for ping in past_a_wall():
        fine.update(ping)
    usual, finer = grid(past_a_wall()).occupancy(), fine.occupancy()
    walls = [
        np.median([image[geometry.cell(x, 1.01)] for x in np.arange(-1.5, 1.5, 0.1)])
        for image, geometry in ((usual, GEOMETRY), (finer, fine.geometry))
    ]
    assert walls[1] == approx(walls[0], abs=0.15)
