from math import hypot, inf

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pytest import approx

from echogrid.mapping.planning.clearance import clearance

plans = arrays(np.bool_, st.tuples(st.integers(1, 12), st.integers(1, 12)))


@settings(deadline=None)
@given(plans, st.integers(1, 15))
def test_it_is_the_distance_to_the_nearest_obstacle_up_to_the_most(plan: np.ndarray, most: int) -> None:
    found = clearance(plan, most)
    obstacles = np.argwhere(plan)
    for (row, col), distance in np.ndenumerate(found):
        nearest = min((hypot(row - r, col - c) for r, c in obstacles), default=inf)
        assert distance == approx(nearest if nearest <= most else inf)
