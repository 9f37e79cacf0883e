"""What a device reports: stamped facts in SI units, never magic numbers."""

from dataclasses import dataclass
from enum import Enum
from math import isnan, nan


class Outcome(Enum):
    """The four things that a ping can tell."""

    ECHO = "echo"
    NO_ECHO = "no echo"
    TOO_CLOSE = "too close"
    INVALID = "invalid"


@dataclass(frozen=True, slots=True)
class RangeReading:
    """One ping's result, at the moment when its sound met the obstacle."""

    stamp_ns: int
    """CLOCK_MONOTONIC, estimated."""
    stamp_error_ns: int
    """How far off the stamp may be."""
    sensor: str
    outcome: Outcome
    distance: float = nan
    """m from the transducer; NaN unless ECHO."""
    raw: bytes = b""
    """The device's own bytes."""
    reason: str = ""
    """Why, when INVALID."""
    later: tuple[float, ...] = ()
    """m: the echoes behind the first, if the device tells them."""
    listened: bool = False
    """It only listened, without a ping of its own: what it heard is not an obstacle but somebody else."""


@dataclass(frozen=True, slots=True)
class WheelReading:
    """One wheel's absolute, unwrapped angle."""

    stamp_ns: int
    stamp_error_ns: int
    wheel: str
    angle: float
    """rad, positive drives the robot forward."""
    rate: float
    """rad/s."""
    discontinuity: bool = False
    """The controller restarted or jumped: the angle was re-baselined with zero motion."""
    raw: bytes = b""


@dataclass(frozen=True, slots=True)
class GyroReading:
    """How fast the robot turns."""

    stamp_ns: int
    stamp_error_ns: int
    gyro: str
    rate: float
    """rad/s, counter-clockwise; the gyro's bias is in it."""
    raw: bytes = b""


Reading = RangeReading | WheelReading | GyroReading


def classify(distance: float, nearest: float, farthest: float) -> tuple[Outcome, float]:
    """The outcome and distance (m, NaN unless ECHO) of a measured distance, given the sensor's blanking
    distance and reach: an echo lies in [nearest, farthest)."""
    if isnan(distance):
        return Outcome.INVALID, nan
    if distance < nearest:
        return Outcome.TOO_CLOSE, nan
    if distance >= farthest:
        return Outcome.NO_ECHO, nan
    return Outcome.ECHO, distance
