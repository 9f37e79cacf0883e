"""What holds for every theory."""

from math import radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.range_layer import RangeLayerGrid
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.theories import THEORIES, Beliefs, maker
from echogrid.mapping.theory import Theory, layers

from .by_hand import Cell
from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-2.0, -2.0, 2.0, 2.0, 0.2)
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.0, 4.0)
CELL = GEOMETRY.cell(0.1, 0.1)

pings = st.tuples(poses(2.0), rangers(0.05), st.none() | st.floats(0.0, 4.0))
names = pytest.mark.parametrize("name", THEORIES)


def theory(name: str, no_echo: NoEcho = NoEcho.WEAK) -> Theory:
    return maker(name, Beliefs(no_echo=no_echo))(GEOMETRY)


@names
@settings(deadline=None, max_examples=40)
@given(many=st.lists(pings, max_size=5), no_echo=st.sampled_from(NoEcho))
def test_occupancy_is_always_a_probability_and_one_half_where_unknown(
    name: str, many, no_echo: NoEcho
) -> None:
    grid = theory(name, no_echo)
    for ping in many:
        grid.update(Sounding(*ping, 0.1))
    occupancy = grid.occupancy()
    assert occupancy.shape == GEOMETRY.shape
    assert occupancy.dtype == np.float32
    assert np.all((occupancy >= 0.0) & (occupancy <= 1.0))
    assert np.all(occupancy[grid.unknown()] == 0.5)


@pytest.mark.parametrize("name", [name for name in THEORIES if name != "himm"])
@settings(deadline=None, max_examples=30)
@given(ping=pings, no_echo=st.sampled_from(NoEcho))
def test_of_region_iii_a_ping_says_nothing(name: str, ping, no_echo: NoEcho) -> None:
    """HIMM has no cone: the axis may cut the corner of a cell whose middle lies off it."""
    grid = theory(name, no_echo)
    grid.update(Sounding(*ping, 0.1))
    for row, col in np.argwhere(~grid.unknown()):
        x, y = float(GEOMETRY.x_centres[col]), float(GEOMETRY.y_centres[row])
        cell = Cell(x, y, ping, GEOMETRY.resolution)
        assert cell.region() != 3 or cell.on_a_border()


@names
@settings(deadline=None, max_examples=20)
@given(many=st.lists(pings, max_size=4))
def test_the_same_pings_give_the_same_bits_and_a_copy_goes_on_as_its_original(name: str, many) -> None:
    first = theory(name)
    for ping in many[:2]:
        first.update(Sounding(*ping, 0.1))
    second = first.copy()
    for ping in many[2:]:
        first.update(Sounding(*ping, 0.1))
        second.update(Sounding(*ping, 0.1))
    assert first.occupancy().tobytes() == second.occupancy().tobytes()
    assert np.array_equal(first.unknown(), second.unknown())


@pytest.mark.parametrize(
    ("name", "most"), [("bayes", 9), ("dempster-shafer", 9), ("himm", 12), ("counting", 100)]
)
def test_after_a_hundred_echoes_some_contrary_pings_lead_across_one_half_and_back(
    name: str, most: int
) -> None:
    """Of counting no fewer than there were; the others forget by their clamps and floors."""
    grid = theory(name)
    at, beyond = (Sounding(Pose(-1.9, 0.1), SONAR, echo, 0.1) for echo in (2.0, 3.0))
    for _ in range(100):
        grid.update(at)
    assert grid.occupancy()[CELL] > 0.5
    for _ in range(most + 1):
        grid.update(beyond)
    assert grid.occupancy()[CELL] < 0.5
    for _ in range(200):
        grid.update(beyond)
    for _ in range(300 if name == "counting" else most + 1):
        grid.update(at)
    assert grid.occupancy()[CELL] > 0.5


@pytest.mark.parametrize("name", ["bayes", "dempster-shafer", "himm"])
def test_silence_means_what_it_is_told_to(name: str) -> None:
    silence = Sounding(Pose(-1.9, 0.1), SONAR, None, 0.1)
    ignoring, clearing = theory(name, NoEcho.IGNORE), theory(name, NoEcho.CLEAR)
    assert ignoring.update(silence) is None
    assert clearing.update(silence) is not None
    assert clearing.occupancy()[CELL] < 0.5


def test_the_baseline_is_none_of_them_but_is_judged_as_they_are() -> None:
    baseline: Theory = RangeLayerGrid(GEOMETRY)
    baseline.update(Sounding(Pose(-1.0, 0.1), SONAR, 1.0, 0.1))
    assert baseline.occupancy().max() > 0.8


def test_a_name_that_is_no_theory_is_refused() -> None:
    with pytest.raises(KeyError):
        maker("guess", Beliefs())(GEOMETRY)


@names
def test_what_else_a_theory_has_to_tell_is_of_all_cells_and_most_have_nothing(name: str) -> None:
    told = layers(theory(name))
    assert set(told) == ({"belief", "plausibility", "conflict"} if name == "dempster-shafer" else set())
    assert all(layer.shape == GEOMETRY.shape for layer in told.values())
