"""The speed of sound in air."""

from math import sqrt


def speed_of_sound(temperature: float) -> float:
    """m/s in dry air of `temperature` °C."""
    return 331.3 * sqrt(1 + temperature / 273.15)
