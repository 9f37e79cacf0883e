"""What every emulated yaw gyro has: a rate that is nearly the true one, and ways to be wrong."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import degrees
from random import Random

from echogrid.emulation.devices.device import LOOKED_UP
from echogrid.emulation.faults import Faults, Verb

GYRO_VERBS: Mapping[str, Verb] = {"drifting": LOOKED_UP, "stuck": LOOKED_UP}
_DRIFT_DPS = 0.2
"""By so much more in each second."""


@dataclass(frozen=True, slots=True)
class GyroOptions:
    """How good it is, and how it tells its rate. `unit` and `scale` are those of the reader: number times
    scale is the rate in that unit, counter-clockwise."""

    bias_dps: float = 0.5
    """What it says when nothing turns."""
    noise_dps: float = 0.05
    """The standard deviation of a number."""
    scale_error: float = 0.0
    """0.01: it says 1 % too much."""
    period_ns: int = 10_000_000
    unit: str = "deg/s"
    scale: float = 1.0

    def __post_init__(self) -> None:
        if not 1_000_000 <= self.period_ns <= 1_000_000_000:
            raise ValueError(f"period_ns {self.period_ns}: it sends 1 to 1000 times a second")
        if self.unit not in ("deg/s", "rad/s"):
            raise ValueError(f"unit {self.unit!r}: there are deg/s and rad/s")
        if not self.scale:
            raise ValueError("scale 0: no number would be a rate")
        if self.noise_dps < 0.0:
            raise ValueError(f"noise_dps {self.noise_dps}: it is a standard deviation")


class RateSensor:
    """The sensing element. `yaw_rate` is the robot's true one (rad/s) by time (ns)."""

    def __init__(
        self, yaw_rate: Callable[[int], float], faults: Faults, random: Random, options: GyroOptions
    ) -> None:
        self.random = random
        self._yaw_rate = yaw_rate
        self._faults = faults
        self._options = options
        self._said = 0.0

    def number(self, now_ns: int) -> float:
        """What it says now, in its unit; called once for each number that it sends."""
        if "stuck" in self._faults:
            return self._said
        options = self._options
        dps = degrees(self._yaw_rate(now_ns)) * (1.0 + options.scale_error)
        dps += options.bias_dps + self._drift(now_ns) + self.random.gauss(0.0, options.noise_dps)
        self._said = dps * (1.0 if options.unit == "deg/s" else 1.0 / degrees(1.0)) / options.scale
        return self._said

    def _drift(self, now_ns: int) -> float:
        """deg/s; it is gone with the fault."""
        since = [fault.since_ns for fault in self._faults.active() if fault.verb == "drifting"]
        return sum(_DRIFT_DPS * (now_ns - since_ns) * 1e-9 for since_ns in since)
