from hypothesis import given
from hypothesis.strategies import floats
from pytest import approx

from echogrid.drivers.sound import speed_of_sound


def test_sound_goes_at_331_metres_a_second_at_the_freezing_point() -> None:
    assert speed_of_sound(0.0) == 331.3


def test_sound_goes_at_343_metres_a_second_in_a_room() -> None:
    assert speed_of_sound(20.0) == approx(343.2, abs=0.1)


@given(floats(-60, 60), floats(0.01, 20))
def test_sound_is_faster_in_warmer_air(temperature: float, more: float) -> None:
    assert speed_of_sound(temperature + more) > speed_of_sound(temperature)
