import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.pose import Pose
from echogrid.runtime.map_picture import picture

from .maps import image

NAN = float("nan")
BLUE, GREEN, RED = (30, 110, 220), (20, 150, 60), (210, 40, 40)
BLACK, WHITE, UNKNOWN = (0, 0, 0), (255, 255, 255), (176, 184, 192)


def has(pixels: NDArray[np.uint8], colour: tuple[int, int, int]) -> bool:
    return bool((pixels == colour).all(axis=2).any())


def test_north_is_up_and_the_three_states_have_their_colours() -> None:
    pixels = picture(image([[0.0] * 10, [1.0] * 10, [NAN] * 10], resolution=0.1), [])
    rows = pixels.shape[0]
    assert tuple(pixels[rows // 6, -1]) == UNKNOWN
    assert tuple(pixels[rows // 2, -1]) == BLACK
    assert tuple(pixels[rows - 2, -1]) == WHITE


def test_only_the_known_part_is_shown() -> None:
    grid = [[NAN] * 400 for _ in range(400)]
    grid[200][200] = 0.0
    small = picture(image(grid, resolution=0.1, x=0.0, y=0.0), [])
    assert small.shape == (999, 999, 3)
    assert small.shape[0] // 9 * 9 == small.shape[0]


def test_the_path_runs_from_green_to_red() -> None:
    grid = [[0.0] * 40 for _ in range(40)]
    pixels = picture(image(grid, resolution=0.1, x=0.0, y=0.0), [Pose(1.0, 2.0), Pose(3.0, 2.0)])
    size = pixels.shape[0] / 4.0
    assert tuple(pixels[round(2 * size), round(size)]) == GREEN
    assert tuple(pixels[round(2 * size), round(2 * size)]) == BLUE
    assert tuple(pixels[round(2 * size), round(3 * size)]) == RED


def test_a_bar_shows_one_metre() -> None:
    pixels = picture(image([[0.0] * 50 for _ in range(50)], resolution=0.1), [])
    bar = (pixels[-8] == BLACK).all(axis=1)
    assert bar.sum() == pixels.shape[1] // 5


def test_a_path_that_leaves_the_map_is_drawn_where_it_is_inside() -> None:
    path = [Pose(1.0, 1.0), Pose(2.0, 1.0), Pose(1e9, -1e9), Pose(-0.1, 0.0)]
    pixels = picture(image([[0.0] * 40 for _ in range(40)], resolution=0.1, x=0.0, y=0.0), path)
    assert has(pixels, BLUE)
    assert not has(pixels, RED)


def test_a_map_of_nothing_is_a_picture_too() -> None:
    pixels = picture(image([[NAN] * 3] * 2), [])
    assert has(pixels, UNKNOWN)
    assert not has(pixels, WHITE)
