"""How a robot moves at a moment."""

from dataclasses import dataclass

_STILL = 1e-9
"""m/s and rad/s."""


@dataclass(frozen=True, slots=True)
class Twist:
    """A motion of base_link."""

    speed: float = 0.0
    """m/s ahead."""
    turn_rate: float = 0.0
    """rad/s counter-clockwise."""

    @property
    def stands(self) -> bool:
        """Whether it is none, or too small to be one."""
        return max(abs(self.speed), abs(self.turn_rate)) < _STILL

    def times(self, factor: float) -> "Twist":
        """The same curve at another speed."""
        return Twist(self.speed * factor, self.turn_rate * factor)
