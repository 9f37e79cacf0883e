import pytest

from echogrid.mapping.cone import cast
from echogrid.mapping.sonar_model import Form, NoEcho
from echogrid.runtime.contenders import contenders
from echogrid.runtime.map_suite import Contender
from echogrid.runtime.stationary import ALIKE, CELLS, GRID, LOOKED_AT, Cell, Moved, moved, sounding

from .theories import counting, ignorant

BAYES = next(
    each
    for each in contenders()
    if each.name == f"Bayes {Form.CONSISTENT.value}, no echo: {NoEcho.IGNORE.value}"
)


@pytest.mark.parametrize("cell", CELLS.values(), ids=CELLS)
def test_every_ping_speaks_of_the_cell_as_it_should(cell: Cell) -> None:
    for index in range(3):
        cone = cast(GRID, sounding(index, cell))
        (found,) = [n for n, at in enumerate(zip(cone.rows, cone.cols, strict=True)) if at == LOOKED_AT]
        assert cone.distance[found] == pytest.approx(cell.distance)
        assert cone.bearing[found] == pytest.approx(cell.bearing, abs=1e-9)
        assert cone.occupied[found] == (cell.behind == 0.0)


def test_what_counts_every_ping_believes_two_hundred_alike_more_than_three() -> None:
    after = moved(Contender("counting", counting), "museum", Cell(2.0, 0.0, 0.0))
    assert (after.once, after.thrice, after.alike) == pytest.approx((1 / 2, 3 / 4, ALIKE / (ALIKE + 1)))
    assert not after.within_three
    assert not after.as_once


def test_what_does_not_move_says_as_much_as_once() -> None:
    after = moved(Contender("ignorant", ignorant), "museum", Cell(2.0, 0.0, 0.0))
    assert after == Moved(0.5, 0.5, 0.5)
    assert after.as_once
    assert after.within_three


@pytest.mark.parametrize(
    ("thrice", "alike", "within"),
    [
        (0.9, 0.9, True),
        (0.9, 0.7, True),
        (0.9, 0.95, False),
        (0.9, 0.1, True),
        (0.2, 0.1, False),
        (0.2, 0.3, True),
    ],
)
def test_further_counts_on_the_side_to_which_three_move_it(thrice: float, alike: float, within: bool) -> None:
    assert Moved(0.5, thrice, alike).within_three is within


def test_bayes_talks_itself_into_what_it_hears_again_and_again() -> None:
    """Off the axis and far, where three pings are not yet at the clamp."""
    for cell in (CELLS["3.5 m, 10 deg off"], CELLS["3.5 m, 10 deg off it"]):
        assert not moved(BAYES, "museum", cell).within_three
