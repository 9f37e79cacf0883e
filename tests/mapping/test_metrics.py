import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pytest import approx

from echogrid.mapping.metrics import MapQuality, free_recall, quality, within

TRUTH = np.array([[0, 0, 0, 1]] * 3, bool)
MAP = np.array([[0.1, 0.2, 0.5, 0.7], [0.1, 0.3, 0.6, 0.9], [0.2, 0.1, 0.4, 0.45]])
EVERYWHERE = np.ones((3, 4), bool)

masks = arrays(bool, (9, 11))


def drawn(*rows: str) -> np.ndarray:
    return np.array([[sign == "#" for sign in row] for row in rows])


@given(masks, st.integers(0, 4))
def test_a_cell_is_within_reach_of_a_set_one_if_any_is_near_enough(mask: np.ndarray, cells: int) -> None:
    found = within(mask, cells)
    places = np.argwhere(mask)
    for row, col in np.ndindex(mask.shape):
        squares = ((places - (row, col)) ** 2).sum(axis=1)
        assert found[row, col] == bool((squares <= cells * cells).any())


@given(masks, masks, masks)
def test_scores_are_parts_of_the_whole(occupied: np.ndarray, walls: np.ndarray, judged: np.ndarray) -> None:
    score = quality(occupied, walls, judged)
    parts = score.precision, score.recall, score.phantoms, score.missed, score.overlap, score.f1
    assert all(0.0 <= part <= 1.0 for part in parts)
    assert min(score.precision, score.recall) <= score.f1 + 1e-12
    assert score.f1 <= max(score.precision, score.recall) + 1e-12
    assert score.precision + score.phantoms <= 1.0
    assert score.recall + score.missed <= 1.0


@given(masks, masks, masks, masks)
def test_cells_that_are_not_judged_cannot_be_false(
    occupied: np.ndarray, walls: np.ndarray, judged: np.ndarray, noise: np.ndarray
) -> None:
    assert quality(occupied | (noise & ~judged), walls, judged) == quality(occupied & judged, walls, judged)


@given(masks, masks)
def test_precision_and_recall_are_each_other_mirrored(one: np.ndarray, other: np.ndarray) -> None:
    everywhere = np.ones_like(one)
    there, back = quality(one, other, everywhere), quality(other, one, everywhere)
    assert (there.precision, there.phantoms) == (back.recall, back.missed)
    assert there.overlap == back.overlap


@given(masks, masks, masks)
def test_without_tolerance_f1_is_a_function_of_the_overlap(
    occupied: np.ndarray, walls: np.ndarray, judged: np.ndarray
) -> None:
    score = quality(occupied, walls, judged, tolerance=0)
    assert score.f1 == approx(2.0 * score.overlap / (1.0 + score.overlap))


@given(masks, masks, masks)
def test_free_space_is_what_is_judged_and_no_wall(
    empty: np.ndarray, walls: np.ndarray, judged: np.ndarray
) -> None:
    cells = [(e, w) for e, w, j in zip(empty.flat, walls.flat, judged.flat, strict=True) if j]
    found = [e for e, w in cells if not w]
    assert free_recall(empty, walls, judged) == approx(sum(found) / max(len(found), 1))


@given(masks.filter(np.any))
def test_the_truth_is_perfect(walls: np.ndarray) -> None:
    assert quality(walls, walls, np.ones_like(walls)) == MapQuality(1.0, 1.0, 0.0, 0.0, 1.0)


def test_the_toy_map_is_perfect_within_one_cell_though_half_of_it_is_wrong() -> None:
    called = MAP > 0.5
    score = quality(called, TRUTH, EVERYWHERE)
    assert score.overlap == 0.5
    assert (score.precision, score.recall, score.f1, score.phantoms) == (1.0, 1.0, 1.0, 0.0)


def test_the_toy_map_without_tolerance() -> None:
    score = quality(MAP > 0.5, TRUTH, EVERYWHERE, tolerance=0)
    assert (score.precision, score.recall) == approx((2 / 3, 2 / 3))


def test_a_cell_more_than_two_cells_from_any_wall_is_a_phantom() -> None:
    walls = drawn("#.......", "#.......")
    called = drawn("#.##...#", "........")
    score = quality(called, walls, np.ones_like(walls))
    assert score.phantoms == approx(2 / 4)
    assert score.precision == approx(1 / 4)


def test_a_wall_more_than_two_cells_from_all_that_is_called_so_is_missed() -> None:
    walls = drawn("#.##...#", "........")
    called = drawn("#.......", "#.......")
    assert quality(called, walls, np.ones_like(walls)).missed == approx(2 / 4)


def test_the_diagonal_neighbour_is_not_within_one_cell() -> None:
    walls, called = drawn("#..", "..."), drawn("...", ".#.")
    assert quality(called, walls, np.ones_like(walls)).precision == 0.0


def test_a_wall_outside_the_judged_cells_still_excuses_a_neighbour() -> None:
    walls, called = drawn("#..."), drawn(".#..")
    score = quality(called, walls, drawn(".###"))
    assert (score.precision, score.phantoms) == (1.0, 0.0)


def test_a_wall_that_is_not_judged_need_not_be_found() -> None:
    walls, called = drawn("#......#"), drawn("#.......")
    assert quality(called, walls, drawn("#####...")).recall == 1.0
    assert quality(called, walls, drawn("########")).recall == 0.5


def test_an_empty_map_finds_nothing() -> None:
    assert quality(~EVERYWHERE, TRUTH, EVERYWHERE) == MapQuality(0.0, 0.0, 0.0, 1.0, 0.0)
    assert quality(~EVERYWHERE, TRUTH, EVERYWHERE).f1 == 0.0
