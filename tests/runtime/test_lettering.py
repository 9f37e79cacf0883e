from itertools import combinations

import numpy as np
import pytest

from echogrid.runtime.compared_theories import WHAT_IT_IS
from echogrid.runtime.lettering import HEIGHT, written

LETTERS = "abcdefghijklmnopqrstuvwxyz0123456789-.,:+/()'"


def test_every_letter_is_drawn_and_like_no_other() -> None:
    drawn = {letter: written(letter, 1) for letter in LETTERS}
    assert all(mask.any() for mask in drawn.values())
    assert not any(np.array_equal(drawn[one], drawn[other]) for one, other in combinations(LETTERS, 2))
    assert not written(" ", 1).any()


def test_an_l_looks_like_one() -> None:
    rows = ["".join(".#"[pixel] for pixel in row) for row in written("L", 1).astype(int)]
    assert rows == [".##...", *["..#..."] * 5, ".###..", "......", "......"]


def test_letters_stand_in_a_row_and_never_touch() -> None:
    mask = written("ab", 3)
    assert mask.shape == (3 * HEIGHT, 2 * 3 * 6)
    assert np.array_equal(mask[:, :18], written("a", 3))
    for letter in LETTERS:
        assert not written(letter, 1)[:, -1].any()


@pytest.mark.parametrize("name", WHAT_IT_IS)
def test_the_name_of_every_theory_can_be_written(name: str) -> None:
    assert written(name, 1).any()


def test_a_letter_that_is_not_drawn_is_refused() -> None:
    with pytest.raises(KeyError):
        written("é", 1)
