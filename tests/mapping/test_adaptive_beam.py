from math import radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.mapping.adaptive_beam import half_angle

WIDEST, NARROWEST = radians(15.0), radians(5.0)
speeds = st.floats(-1.0, 2.0)


@given(speeds)
def test_the_cone_stays_between_its_bounds(speed: float) -> None:
    assert NARROWEST - 1e-12 <= half_angle(speed, WIDEST, NARROWEST, 0.4) <= WIDEST


@given(speeds, speeds)
def test_a_faster_robot_never_has_a_wider_cone(one: float, other: float) -> None:
    slow, fast = sorted((one, other))
    assert half_angle(fast, WIDEST, NARROWEST, 0.4) <= half_angle(slow, WIDEST, NARROWEST, 0.4)


@pytest.mark.parametrize(("speed", "beta"), [(0.0, 15.0), (0.2, 10.0), (0.3, 7.5), (0.4, 5.0), (0.7, 5.0)])
def test_in_between_it_narrows_evenly(speed: float, beta: float) -> None:
    assert half_angle(speed, WIDEST, NARROWEST, 0.4) == pytest.approx(radians(beta))
