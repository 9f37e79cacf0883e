"""Within what the twist of a robot may lie and change."""

from dataclasses import dataclass

from echogrid.mapping.twist import Twist


@dataclass(frozen=True, slots=True)
class Limits:
    """Of a robot with a differential drive."""

    speed: float = 0.5
    """m/s, forward and back."""
    turn_rate: float = 1.5
    """rad/s."""
    acceleration: float = 0.5
    """m/s^2, also when it slows down."""
    turn_acceleration: float = 3.0
    """rad/s^2."""

    def __post_init__(self) -> None:
        if not min(self.speed, self.turn_rate, self.acceleration, self.turn_acceleration) > 0.0:
            raise ValueError("the limits of a robot that is to move must all be above 0")

    def turning_radius(self, speed: float) -> float:
        """m, of the tightest curve at that speed; 0 for a robot that turns in place."""
        return abs(speed) / self.turn_rate

    def reach(self, wish: Twist, now: Twist, elapsed_s: float) -> Twist:
        """What of a wish the robot can come to from `now` in that time; never beyond the limits."""
        return Twist(
            _stepped(now.speed, wish.speed, self.acceleration * elapsed_s, self.speed),
            _stepped(now.turn_rate, wish.turn_rate, self.turn_acceleration * elapsed_s, self.turn_rate),
        )


def bounded(value: float, most: float) -> float:
    """The value, brought into -most...most."""
    return min(max(value, -most), most)


def _stepped(now: float, wish: float, step: float, most: float) -> float:
    return bounded(now + bounded(wish - now, step), most)
