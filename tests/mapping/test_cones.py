"""Cones that are cast together beside those that are cast one by one: the same, to the bit."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping.cone import Reach, cast
from echogrid.mapping.cones import cast_all
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sounding import Sounding

from .strategies import poses, rangers


@settings(deadline=None)
@given(
    st.lists(st.tuples(poses(4.0), rangers()), min_size=1, max_size=5),
    st.sampled_from([0.05, 0.1, 0.3]),
    st.floats(0.5, 1.0),
)
def test_each_has_the_cells_that_it_has_alone(
    pings: list[tuple[Pose, Ranger]], resolution: float, part: float
) -> None:
    geometry = GridGeometry.covering(-2.5, -3.0, 3.0, 2.5, resolution)
    pings = [
        (seat, replace(ranger, half_angle=part * ranger.half_angle, farthest=part * ranger.farthest))
        for seat, ranger in pings
    ]
    cones = cast_all(geometry, [(seat, Reach(each.half_angle, each.farthest)) for seat, each in pings])
    assert (cones.borders[0], cones.borders[-1]) == (0, len(cones.cells))
    for number, (seat, ranger) in enumerate(pings):
        alone = cast(geometry, Sounding(seat, ranger, None, 0.1))
        here = slice(cones.borders[number], cones.borders[number + 1])
        order = np.argsort(cones.cells[here])
        assert np.all(cones.ping[here] == number)
        assert np.array_equal(cones.cells[here][order], alone.cells)
        assert np.array_equal(cones.distance[here][order], alone.distance)
        assert np.array_equal(cones.bearing[here][order], alone.bearing)
