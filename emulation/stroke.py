"""How one axis of motion goes from rest to rest."""

from dataclasses import dataclass
from math import copysign, sqrt


@dataclass(frozen=True, slots=True)
class Stroke:
    """One axis that goes a signed way from rest to rest: speeds up, cruises, slows down."""

    way: float
    """m or rad."""
    acceleration: float
    """Per s^2."""
    ramp: float
    """s: how long it speeds up, and slows down."""
    duration: float
    """s."""

    @classmethod
    def of(cls, way: float, top_speed: float, acceleration: float) -> "Stroke":
        """The quickest stroke within the limits."""
        ramp = min(top_speed / acceleration, sqrt(abs(way) / acceleration))
        cruise = abs(way) / (acceleration * ramp) - ramp if ramp else 0.0
        return cls(way, acceleration, ramp, 2.0 * ramp + cruise)

    def at(self, t_s: float) -> tuple[float, float]:
        """Way gone and speed at a time since its start, 0 to duration."""
        left = self.duration - t_s
        if t_s < self.ramp:
            gone, speed = 0.5 * self.acceleration * t_s**2, self.acceleration * t_s
        elif left < self.ramp:
            gone, speed = abs(self.way) - 0.5 * self.acceleration * left**2, self.acceleration * left
        else:
            speed = self.acceleration * self.ramp
            gone = speed * (t_s - 0.5 * self.ramp)
        return copysign(gone, self.way), copysign(speed, self.way)
