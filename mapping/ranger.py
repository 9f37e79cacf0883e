"""A range sensor as the map sees it: where it sits, how wide and far it looks, and what its silence means."""

from dataclasses import dataclass
from enum import Enum
from math import pi, sqrt

from echogrid.mapping.pose import Pose


class NoEcho(Enum):
    """What it means that nothing came back."""

    IGNORE = "ignore"
    WEAK = "weak"
    CLEAR = "clear"


@dataclass(frozen=True, slots=True)
class Ranger:
    """A mounted range sensor. `mount` is the transducer's pose in base_link."""

    name: str
    mount: Pose
    half_angle: float
    """rad, beta of the book."""
    nearest: float
    """m, the blanking distance."""
    farthest: float
    """m, R of the book."""
    tolerance: float | None = None
    """m: half the thickness of the band in which an obstacle lies, at least; None: as for all rangers."""
    no_echo: NoEcho | None = None
    """None: as for all rangers."""
    detection: float | None = None
    """p_d: how often an obstacle on the axis and near answers; None: as the sonar model has it."""

    def __post_init__(self) -> None:
        if not 0.0 < self.half_angle < pi / 2.0:
            raise ValueError("a cone's half angle lies between 0 and 90 degrees")
        if not 0.0 <= self.nearest < self.farthest:
            raise ValueError("a ranger's nearest distance is at least 0 and below its farthest")
        if self.detection is not None and not 0.0 <= self.detection < 1.0:
            raise ValueError("a probability of detection is at least 0 and below 1")


def effective_tolerance(tolerance: float, resolution: float, distance: float) -> float:
    """Half the thickness (m) of the band in which an echo's obstacle lies.

    At least `tolerance`, half a cell's diagonal (so that every ray meets a cell), and two standard
    deviations of the range, max(1 cm, 1 %).
    """
    return max(tolerance, resolution * sqrt(0.5), 2.0 * max(0.01, 0.01 * distance))
