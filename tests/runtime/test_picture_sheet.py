import numpy as np

from echogrid.runtime import png
from echogrid.runtime.grey_image import read_grey
from echogrid.runtime.picture_sheet import GAP, Gallery, Picture, Pixels, enlarged, sheet, sheets

SHADES = 50, 80, 110, 140, 170


def pictures() -> list[Picture]:
    return [Picture(f"n{shade}", "", np.full((2, 3, 3), shade, np.uint8)) for shade in SHADES]


def spots(pixels: Pixels, shade: int) -> tuple[int, int]:
    """The first row and column of a picture."""
    rows, cols = np.nonzero((pixels == shade).all(axis=2))
    return int(rows.min()), int(cols.min())


def test_a_sheet_holds_every_picture_in_its_order() -> None:
    pixels = sheet(pictures())
    first, second, *_, last = (spots(pixels, shade) for shade in SHADES)
    wide = (pixels.shape[1] - 3 * GAP) // 4
    assert [spots(pixels, shade)[1] for shade in SHADES[:4]] == [index * (wide + GAP) for index in range(4)]
    assert second[0] == first[0]
    assert last == (first[0] + (pixels.shape[0] + GAP) // 2, 0)
    assert int(pixels[-1, -1, 0]) == 255
    assert read_grey(png.encode(pixels)).shape == pixels.shape[:2]


def test_each_picture_stands_beneath_its_name() -> None:
    pixels = sheet(pictures())
    row, col = spots(pixels, SHADES[1])
    head = pixels[:row, col : col + 100, 0]
    assert set(np.unique(head)) == {40, 255}
    assert not np.array_equal(head, pixels[:row, :100, 0])


def test_so_many_stand_abreast_as_is_asked_for() -> None:
    pixels = sheet(pictures(), abreast=2)
    assert spots(pixels, SHADES[2])[1] == spots(pixels, SHADES[0])[1] == 0


def test_galleries_stand_beneath_each_other_and_their_titles() -> None:
    first, *others = pictures()
    galleries = [Gallery("one", (), (), (first,), 1), Gallery("two", (), (), tuple(others))]
    pixels = sheets(galleries)
    assert pixels.shape[1] == max(sheet(each.pictures, each.abreast).shape[1] for each in galleries)
    assert spots(pixels, SHADES[0])[0] > 2 * GAP
    rows, _ = np.nonzero((pixels == SHADES[0]).all(axis=2))
    assert spots(pixels, SHADES[1])[0] > int(rows.max()) + 2 * GAP


def test_a_name_with_too_little_room_is_cut() -> None:
    narrow = [Picture(name * 500, "", np.full((2, 3, 3), 50, np.uint8)) for name in "xy"]
    pixels = sheet(narrow, abreast=2)
    assert pixels.shape == sheet(pictures()[:2], abreast=2).shape
    assert (pixels[:, (pixels.shape[1] - GAP) // 2 : (pixels.shape[1] + GAP) // 2] == 255).all()


def test_pixels_are_enlarged_both_ways() -> None:
    assert enlarged(np.array([[[1, 2, 3]]], np.uint8), 2).tolist() == [[[1, 2, 3]] * 2] * 2
