from math import nan, pi, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger, effective_tolerance


@given(st.floats(0, 1), st.floats(0.01, 1), st.floats(0, 10))
def test_the_band_is_as_thick_as_its_most_demanding_reason(
    tolerance: float, resolution: float, distance: float
) -> None:
    band = effective_tolerance(tolerance, resolution, distance)
    reasons = (tolerance, resolution * sqrt(2.0) / 2.0, 0.02, 0.02 * distance)
    assert all(band >= reason - 1e-12 for reason in reasons)
    assert any(band == approx(reason) for reason in reasons)


@pytest.mark.parametrize("half_angle", [0.0, -0.1, pi / 2.0, nan])
def test_a_half_angle_that_is_no_cone_is_refused(half_angle: float) -> None:
    with pytest.raises(ValueError, match="half angle"):
        Ranger("sonar", Pose(), half_angle, 0.1, 4.0)


@pytest.mark.parametrize(
    ("nearest", "farthest"), [(-0.1, 4.0), (4.0, 4.0), (5.0, 4.0), (nan, 4.0), (0.1, nan)]
)
def test_a_reach_that_is_none_is_refused(nearest: float, farthest: float) -> None:
    with pytest.raises(ValueError, match="nearest"):
        Ranger("sonar", Pose(), 0.2, nearest, farthest)
