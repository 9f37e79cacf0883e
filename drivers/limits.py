"""Limits of settings, checked once and told in one way."""


def require_between(key: str, value: int | float, lowest: int | float, highest: int | float) -> None:
    """Raise ValueError, naming key and range, unless lowest <= value <= highest; the key is robot.toml's."""
    if not lowest <= value <= highest:
        raise ValueError(f"{key} is {value}: expected {lowest} to {highest}")


def clipped(value: float, most: float) -> float:
    """The nearest value in [-most, most]."""
    return min(max(value, -most), most)
