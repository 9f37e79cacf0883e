import numpy as np

from echogrid.runtime.map_picture import UNKNOWN
from echogrid.runtime.theory_pictures import GRID, pictures, scenes


def test_every_scene_is_shown_by_all_three_theories() -> None:
    shown = list(pictures())
    assert len(shown) == 4 * len(scenes())
    assert {picture.pixels.shape for picture in shown} == {(GRID.rows, GRID.cols, 3)}


def test_himm_touches_the_fewest_cells_and_the_others_the_same() -> None:
    for first in range(0, 12, 4):
        bayes, masses, conflict, himm = (
            picture.pixels != np.array(UNKNOWN) for picture in list(pictures())[first : first + 4]
        )
        assert himm.any(axis=2).sum() < 0.5 * bayes.any(axis=2).sum()
        assert np.array_equal(bayes.any(axis=2), conflict.any(axis=2))
        assert not (masses & ~bayes.any(axis=2, keepdims=True)).any()


def test_two_pings_that_agree_on_nothing_have_a_conflict_and_one_has_none() -> None:
    shown = list(pictures())
    alone, two = shown[2].pixels, shown[6].pixels
    white, unknown = (255, 255, 255), UNKNOWN
    assert {tuple(pixel) for pixel in alone.reshape(-1, 3)} == {white, unknown}
    assert not {tuple(pixel) for pixel in two.reshape(-1, 3)} <= {white, unknown}
