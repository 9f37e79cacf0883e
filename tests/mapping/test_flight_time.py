"""Time of flight: the speed of sound is the drivers'; the figures are the sonar model's."""

import pytest
from pytest import approx

from echogrid.drivers.sound import speed_of_sound


@pytest.mark.parametrize(
    ("temperature", "speed"),
    [(-10.0, 325.1790221), (0.0, 331.3), (20.0, 343.2146227), (40.0, 354.7292833)],
)
def test_the_speed_of_sound(temperature: float, speed: float) -> None:
    assert speed_of_sound(temperature) == approx(speed, abs=1e-6)


@pytest.mark.parametrize(("temperature", "distance"), [(20.0, 1.0004706), (0.0, 0.9657395)])
def test_how_far_5830_microseconds_reach(temperature: float, distance: float) -> None:
    assert speed_of_sound(temperature) * 5830e-6 / 2.0 == approx(distance, abs=1e-6)


@pytest.mark.parametrize(("temperature", "error"), [(0.0, 0.1436764), (40.0, -0.1300066)])
def test_what_a_fixed_speed_costs_at_4_m(temperature: float, error: float) -> None:
    assert 4.0 * 343.2 / speed_of_sound(temperature) - 4.0 == approx(error, abs=1e-6)
