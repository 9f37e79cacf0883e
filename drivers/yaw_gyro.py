"""What every yaw gyro has, whatever tells its rate: its unit, the moment it speaks of, what it can't turn."""

from collections import Counter
from dataclasses import dataclass
from math import isfinite, radians
from typing import Literal

from echogrid.drivers.freshness import is_old
from echogrid.drivers.limits import require_between
from echogrid.drivers.readings import GyroReading
from echogrid.drivers.role import GyroRole

LONGEST_LAG_MS = 200.0
"""What is later can't be waited for."""
ERROR_NS = 2_000_000
"""How far off a stamp may be: what the host and an adapter hold up."""


@dataclass(frozen=True, slots=True)
class GyroSettings:
    """The keys in a config file that all gyros have."""

    unit: Literal["rad/s", "deg/s"] = "deg/s"
    """What the number is in, after `scale`."""
    scale: float = 1.0
    """By which the number is multiplied; negative if it counts clockwise."""
    fastest_dps: float = 2000.0
    """A quicker turn is not believed."""
    lag_ms: float = 0.0
    """From the moment that a number speaks of to when it is sent: half of what is averaged, and filters."""

    def __post_init__(self) -> None:
        if not 1e-9 <= abs(self.scale) <= 1e9:
            raise ValueError(f"scale is {self.scale}: expected 1e-9 to 1e9, or below 0 as far")
        require_between("fastest_dps", self.fastest_dps, 1.0, 1e5)
        require_between("lag_ms", self.lag_ms, 0.0, LONGEST_LAG_MS)

    @property
    def factor(self) -> float:
        """From the number to rad/s, counter-clockwise."""
        return self.scale * (radians(1.0) if self.unit == "deg/s" else 1.0)


class YawGyro:
    """A gyro that is only listened to. Which drivers are for gyros shows by this class."""

    def __init__(self, role: GyroRole, settings: GyroSettings) -> None:
        self.name = role.name
        self._factor = settings.factor
        self._fastest = radians(settings.fastest_dps)
        self._lag_ns = round(settings.lag_ms * 1e6)
        self._counts: Counter[str] = Counter()
        self._heard_ns: int | None = None
        """When anything of its own came last."""
        self._believed_ns: int | None = None

    def _read(self, sent_ns: int, number: float, raw: bytes) -> tuple[GyroReading, ...]:
        """The reading of a number that was sent then; none if the robot can't turn so."""
        rate = number * self._factor
        if not isfinite(rate):
            self._counts["no numbers"] += 1
            return ()
        if abs(rate) > self._fastest:
            self._counts["impossible rates"] += 1
            return ()
        self._counts["rates"] += 1
        self._believed_ns = sent_ns
        return (GyroReading(sent_ns - self._lag_ns, ERROR_NS, self.name, rate, raw),)

    def _silent(self, now_ns: int) -> bool:
        return is_old(self._heard_ns, now_ns)

    def _believed(self, now_ns: int) -> bool:
        return not is_old(self._believed_ns, now_ns)


def is_for_gyros(driver: object) -> bool:
    """Whether a driver's class reads yaw gyros."""
    return isinstance(driver, type) and issubclass(driver, YawGyro)
