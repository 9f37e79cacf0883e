from math import log, pi, radians

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.forward_model import ForwardGrid, Pings, Settings, fitted, slope
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sounding import Sounding

from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-2.0, -2.0, 2.0, 2.0, 0.1)
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.1, 4.0)

soundings = st.builds(Sounding, poses(2.0), rangers(), st.none() | st.floats(0.0, 4.0), st.just(0.12))


def pings(*cones: tuple[bool, list[tuple[int, float, bool]]]) -> Pings:
    """Of each whether an echo came, and its cells: index, weight, in the band."""
    cells, weights, in_band = (
        np.array(each) for each in zip(*(c for _, cone in cones for c in cone), strict=True)
    )
    starts = np.cumsum([0, *(len(cone) for _, cone in cones[:-1])])
    echo = np.array([heard for heard, _ in cones])
    return Pings(cells, weights.astype(float), in_band, starts, echo, np.full(len(cones), 5.0))


ECHO = pings((True, [(0, 1.0, False), (1, 1.0, False), (2, 1.0, False), (3, 1.0, True), (4, 0.5, True)]))


def test_the_worked_example() -> None:
    found = slope(ECHO, np.array([0.05, 0.05, 0.05, 0.3, 0.1]), Settings(stray=0.12, band=0.12))
    assert found.likelihood == approx(0.9559835, abs=1e-6)
    assert log(found.likelihood[0]) == approx(-0.0450146, abs=1e-6)
    due = [-0.9748950, -0.9748950, -0.9748950, 2.3263433, 1.1631716]
    assert found.rise == approx(np.array(due), abs=1e-6)


cones = st.lists(
    st.tuples(
        st.booleans(),
        st.lists(st.tuples(st.integers(0, 5), st.floats(0.0, 1.0), st.booleans()), min_size=1, max_size=6),
    ),
    min_size=1,
    max_size=4,
)


@given(cones, st.lists(st.floats(0.01, 2.0), min_size=6, max_size=6))
def test_the_rise_is_that_of_the_likelihood(made, hazards: list[float]) -> None:
    made = [(echo, [(c, w, echo and band) for c, w, band in cone]) for echo, cone in made]
    asked, hazard = pings(*made), np.array(hazards)
    rise = np.bincount(asked.cells, slope(asked, hazard).rise, 6)
    for cell in range(6):
        step = np.zeros(6)
        step[cell] = 1e-6
        up, down = (np.log(slope(asked, hazard + way * step).likelihood).sum() for way in (1.0, -1.0))
        assert rise[cell] == approx((up - down) / 2e-6, abs=1e-4)


def test_fitting_makes_the_pings_likelier() -> None:
    wall = [(True, [(n, 1.0, False) for n in range(3)] + [(3, 1.0, True), (4, 1.0, True)])] * 3
    clear = (True, [(3, 1.0, False), (5, 1.0, True)])
    asked = pings(*wall, clear)
    before, after = (np.log(slope(asked, h).likelihood).sum() for h in (np.full(6, 0.05), fitted(asked, 6)))
    assert after > before


def test_one_wall_explains_all_echoes_and_what_another_ping_passes_is_no_part_of_it() -> None:
    grid = ForwardGrid(GEOMETRY)
    for x in np.arange(-1.0, 1.0, 0.1):
        grid.update(Sounding(Pose(x, -1.0, pi / 2.0), SONAR, 2.0, 0.12))
    grid.update(Sounding(Pose(-1.5, 0.5, 0.0), SONAR, 3.0, 0.12))
    p = grid.occupancy()
    assert p[GEOMETRY.cell(0.0, 1.0)] > 0.5
    assert p[GEOMETRY.cell(0.0, 0.5)] < 0.05
    assert grid.unknown()[GEOMETRY.cell(0.0, 1.5)]


@settings(deadline=None, max_examples=20)
@given(st.lists(soundings, max_size=5))
def test_probabilities_are_such_and_half_where_nobody_spoke(many: list[Sounding]) -> None:
    grid = ForwardGrid(GEOMETRY)
    for each in many:
        grid.update(each)
    twin = grid.copy()
    p = grid.occupancy()
    assert np.all((p >= 0.0) & (p <= 1.0))
    assert np.all(p[grid.unknown()] == 0.5)
    assert np.array_equal(twin.occupancy(), p)
