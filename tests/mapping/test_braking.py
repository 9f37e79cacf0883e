import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.braking import Brakes, speed_limit, stopping_distance

ways, latencies = st.floats(0.0, 50.0), st.floats(0.0, 5.0)
brakes = st.builds(Brakes, st.floats(0.01, 20.0), st.floats(0.0, 1.0))


@pytest.mark.parametrize(("speed", "distance"), [(0.5, 0.375), (0.78, 0.803), (0.0, 0.0)])
def test_the_stopping_distance_is_that_of_the_worked_examples(speed: float, distance: float) -> None:
    """0.25 s of latency, 0.5 m/s^2."""
    assert stopping_distance(speed, 0.25, 0.5) == approx(distance, abs=5e-4)
    assert speed_limit(distance + 0.1, 0.25, Brakes(0.5, 0.1)) == approx(speed, abs=1e-3)


@given(ways, latencies, brakes)
def test_the_limit_leaves_the_stopping_distance_and_the_margin_and_wastes_nothing(
    free: float, latency_s: float, robot: Brakes
) -> None:
    limit = speed_limit(free, latency_s, robot)
    left = free - robot.margin
    assert limit >= 0.0
    if left <= 0.0:
        assert limit == 0.0
    else:
        assert stopping_distance(limit, latency_s, robot.deceleration) == approx(left, rel=1e-9)


@given(ways, ways, latencies, latencies, brakes)
def test_less_room_or_more_latency_never_raises_the_limit(
    one: float, other: float, early_s: float, late_s: float, robot: Brakes
) -> None:
    near, far = sorted((one, other))
    quick, slow = sorted((early_s, late_s))
    assert speed_limit(near, slow, robot) <= speed_limit(far, quick, robot) * (1.0 + 1e-12)
