"""UMBmark: a differential drive's systematic errors from square runs in both directions.

Borenstein & Feng, "Measurement and correction of systematic odometry errors in mobile robots",
IEEE Transactions on Robotics and Automation 12(6), 1996.
"""

from dataclasses import dataclass
from math import hypot, pi, sin


@dataclass(frozen=True, slots=True)
class Corrections:
    """What is wrong with the wheels, and the factors that mend it."""

    alpha: float
    """rad a corner, the part of the error which has the same sign in both directions (wrong track)."""
    beta: float
    """rad a side, the part which changes its sign (unequal wheels)."""
    diameter_ratio: float
    """E_d, right wheel over left wheel."""
    track_factor: float
    """E_b, true track over nominal track."""

    @property
    def left(self) -> float:
        """The factor of the left wheel's radius, c_L."""
        return 2.0 / (self.diameter_ratio + 1.0)

    @property
    def right(self) -> float:
        """The factor of the right wheel's radius, c_R."""
        return 2.0 / (1.0 / self.diameter_ratio + 1.0)


def worst_error(clockwise: tuple[float, float], counterclockwise: tuple[float, float]) -> float:
    """E_max,syst: the larger distance (m) of the two centres of gravity from the start."""
    return max(hypot(*clockwise), hypot(*counterclockwise))


def corrections(clockwise_x: float, counterclockwise_x: float, side: float, track: float) -> Corrections:
    """The corrections from the mean end errors in x (absolute minus odometry, m) of square runs.

    `side` is the square's, `track` the nominal distance of the wheels, m. The paper's radius of the bent
    side, R = (L/2)/sin(beta/2), is infinite for equal wheels, so E_d = (R + b/2)/(R - b/2) is taken times
    2 sin(beta/2) above and below.
    """
    alpha = (clockwise_x + counterclockwise_x) / (-4.0 * side)
    beta = (clockwise_x - counterclockwise_x) / (-4.0 * side)
    track_factor = (pi / 2.0) / (pi / 2.0 - alpha)
    bend = track * sin(beta / 2.0)
    return Corrections(alpha, beta, (side + bend) / (side - bend), track_factor)
