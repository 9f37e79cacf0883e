"""How a robot moves at a moment."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Twist:
    """A motion of base_link."""

    speed: float = 0.0
    """m/s ahead."""
    turn_rate: float = 0.0
    """rad/s counter-clockwise."""

    @property
    def stands(self) -> bool:
        """Whether it is none."""
        return self.speed == 0.0 and self.turn_rate == 0.0

    def times(self, factor: float) -> "Twist":
        """The same curve at another speed."""
        return Twist(self.speed * factor, self.turn_rate * factor)
