"""How fast one may go and still stop in time."""

from dataclasses import dataclass
from math import sqrt


@dataclass(frozen=True, slots=True)
class Brakes:
    """How a robot stops."""

    deceleration: float = 0.5
    """m/s^2, of the point of the robot that moves fastest."""
    margin: float = 0.05
    """m that must be left when it stands."""


def stopping_distance(speed: float, latency_s: float, deceleration: float) -> float:
    """m from the moment when an obstacle answers a ping to standing: v t + v^2 / (2 a)."""
    return speed * latency_s + speed**2 / (2.0 * deceleration)


def speed_limit(free: float, latency_s: float, brakes: Brakes) -> float:
    """m/s: the highest whose stopping distance fits into a free distance (m) less the margin; else 0."""
    left = free - brakes.margin
    if left <= 0.0:
        return 0.0
    # The root of v^2 / (2 a) + v t = left, in the form that does not cancel.
    slow = brakes.deceleration * latency_s
    root = slow + sqrt(slow**2 + 2.0 * brakes.deceleration * left)
    return 2.0 * brakes.deceleration * left / root if root else 0.0
