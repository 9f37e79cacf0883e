import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.long_term_map import LongTermMap
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import Form, NoEcho
from echogrid.mapping.sounding import Sounding

from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-3.0, -2.0, 3.0, 2.0, 0.1)
SONAR = Ranger("sonar", Pose(), 0.26, 0.0, 4.0)


def bayes(geometry: GridGeometry) -> BayesGrid:
    return BayesGrid(geometry, 4.6, Form.CONSISTENT, NoEcho.WEAK)


@settings(deadline=None)
@given(st.lists(st.tuples(poses(3.0), rangers(), st.none() | st.floats(0.0, 4.0)), max_size=5))
def test_one_submap_at_the_origin_is_the_map(pings) -> None:
    long_term, grid = LongTermMap(GEOMETRY, 0.1, bayes), bayes(GEOMETRY)
    for seat, ranger, echo in pings:
        long_term.fuse(seat, ranger, echo)
        grid.update(Sounding(Pose().compose(seat), ranger, echo, 0.1))
    image = long_term.render()
    assert np.array_equal(image.occupancy, grid.occupancy())
    assert np.array_equal(image.unknown, grid.unknown())
    assert image.geometry == GEOMETRY


def test_an_echo_within_the_area_is_fused() -> None:
    assert LongTermMap(GEOMETRY, 0.1, bayes).fuse(Pose(), SONAR, 1.0)


def test_a_ping_outside_the_area_is_not() -> None:
    assert not LongTermMap(GEOMETRY, 0.1, bayes).fuse(Pose(20.0, 0.0), SONAR, 1.0)


def test_an_image_does_not_change_with_the_map() -> None:
    long_term = LongTermMap(GEOMETRY, 0.1, bayes)
    image = long_term.render()
    long_term.fuse(Pose(), SONAR, 1.0)
    assert image.unknown.all()
    assert np.all(image.occupancy == 0.5)


def test_an_obstacle_straight_ahead_is_where_it_is() -> None:
    long_term = LongTermMap(GEOMETRY, 0.1, bayes)
    long_term.fuse(Pose(0.05, 0.05), SONAR, 1.0)
    occupancy = long_term.render().occupancy
    row, ahead = GEOMETRY.cell(1.05, 0.05)
    assert occupancy[row, ahead] > 0.5
    assert occupancy[row, ahead - 4] < 0.5
    assert occupancy[row, ahead + 4] == 0.5
