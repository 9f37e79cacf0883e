"""A reading as text: for a person, and for a program."""

from math import degrees, isnan
from typing import Any

from echogrid.drivers.readings import GyroReading, Outcome, RangeReading, Reading, WheelReading


def as_line(reading: Reading, start_ns: int) -> str:
    """One line; times count from the start."""
    seconds = (reading.stamp_ns - start_ns) * 1e-9
    raw = reading.raw.hex(" ")
    return f"{seconds:9.3f} s  {source(reading)}  {said(reading)}  [{raw}]"


def source(reading: Reading) -> str:
    """The name of the device that tells it."""
    if isinstance(reading, RangeReading):
        return reading.sensor
    return reading.wheel if isinstance(reading, WheelReading) else reading.gyro


def said(reading: Reading) -> str:
    """What it says, in few words."""
    if isinstance(reading, GyroReading):
        return f"{degrees(reading.rate):+.3f} deg/s"
    if isinstance(reading, WheelReading):
        restarted = "  restarted" if reading.discontinuity else ""
        return f"{reading.angle:+.4f} rad  {reading.rate:+.3f} rad/s{restarted}"
    if reading.outcome is Outcome.ECHO:
        return ", ".join(f"{distance:.3f}" for distance in (reading.distance, *reading.later)) + " m"
    if reading.outcome is Outcome.INVALID:
        return f"invalid: {reading.reason}"
    return str(reading.outcome.value)


def as_object(reading: Reading) -> dict[str, Any]:
    """What JSON can carry: null where there is no number."""
    common = {
        "stamp_ns": reading.stamp_ns,
        "stamp_error_ns": reading.stamp_error_ns,
        "raw": reading.raw.hex(),
    }
    if isinstance(reading, RangeReading):
        return {
            "sensor": reading.sensor,
            "outcome": reading.outcome.value,
            "distance_m": None if isnan(reading.distance) else reading.distance,
            "later_m": list(reading.later),
            "reason": reading.reason,
            "listened": reading.listened,
            **common,
        }
    if isinstance(reading, GyroReading):
        return {"gyro": reading.gyro, "rate_rad_s": reading.rate, **common}
    return {
        "wheel": reading.wheel,
        "angle_rad": reading.angle,
        "rate_rad_s": reading.rate,
        "discontinuity": reading.discontinuity,
        **common,
    }
