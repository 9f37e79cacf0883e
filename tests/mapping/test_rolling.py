import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from echogrid.mapping.rolling import shifted

shifts = st.integers(-9, 9)


@given(st.integers(1, 7), st.integers(1, 7), shifts, shifts)
def test_each_cell_shows_what_was_as_far_ahead_as_the_window_moved(
    rows: int, cols: int, down: int, right: int
) -> None:
    array = np.arange(1, rows * cols + 1).reshape(rows, cols)
    moved = shifted(array, (down, right))
    for row in range(rows):
        for col in range(cols):
            inside = 0 <= row + down < rows and 0 <= col + right < cols
            assert moved[row, col] == (array[row + down, col + right] if inside else 0)


@given(shifts, shifts)
def test_the_kind_of_the_array_is_kept_and_the_old_one_untouched(down: int, right: int) -> None:
    array = np.ones((5, 5), np.int16)
    assert shifted(array, (down, right)).dtype == np.int16
    assert array.all()
