"""How a run is going, in one line."""

from dataclasses import dataclass
from math import degrees, isinf

from echogrid.drivers.device import Level
from echogrid.runtime.acquisition import DeviceReport
from echogrid.runtime.fusion import Snapshot
from echogrid.runtime.loop import SECOND_NS, FixedRateLoop

_EVERY_NS = SECOND_NS


@dataclass(frozen=True, slots=True)
class Status:
    """A run, looked at."""

    elapsed_s: float
    tick_rate_hz: float
    """Since the last look."""
    late: int
    skipped: int
    readings_per_s: float
    """Since the last look."""
    snapshot: Snapshot
    devices: tuple[DeviceReport, ...]
    drive: str = ""
    """How it drives, if it does."""

    def line(self) -> str:
        """For a terminal, what matters most first: a narrow one shows no more than 79 characters."""
        return (
            f"{self.elapsed_s:6.1f} s  {self._way():12}  {self._drive()}{self._nearest():26}  "
            f"{self.snapshot.travelled:5.1f} m driven  {self._health()}  {self.tick_rate_hz:.1f} Hz  "
            f"late {self.late}  skipped {self.skipped}  {self.readings_per_s:.0f} readings/s"
        )

    def _way(self) -> str:
        reason = self.snapshot.view.reason
        return f"STOP {reason.value}" if reason else "free"

    def _drive(self) -> str:
        return f"{self.drive}  " if self.drive else ""

    def _nearest(self) -> str:
        nearest = self.snapshot.view.nearest
        if isinf(nearest.nearest):
            return "nearest none"
        return f"nearest {nearest.nearest:.2f} m at {degrees(nearest.bearing):+4.0f} deg"

    def _health(self) -> str:
        ailing = [each.device for each in self.devices if each.health.level is not Level.OK]
        well = f"{len(self.devices) - len(ailing)}/{len(self.devices)} ok"
        slip = "  SLIP" if self.snapshot.slipping else ""
        return (f"{well}: {', '.join(ailing)}" if ailing else well) + slip


class Meter:
    """Looks at a run about once a second."""

    def __init__(self, started_ns: int) -> None:
        self._started_ns = started_ns
        self._looked_ns = started_ns
        self._ticks = 0
        self._readings = 0

    def count(self, readings: int) -> None:
        """A tick took in so many readings."""
        self._ticks += 1
        self._readings += readings

    def due(self, now_ns: int) -> bool:
        """Whether it is time to look."""
        return now_ns - self._looked_ns >= _EVERY_NS

    def look(self, snapshot: Snapshot, loop: FixedRateLoop, devices: list[DeviceReport]) -> Status:
        """The status at the snapshot's time; what is counted from here on is the next one's."""
        seconds = max(snapshot.stamp_ns - self._looked_ns, 1) / SECOND_NS
        status = Status(
            (snapshot.stamp_ns - self._started_ns) / SECOND_NS,
            self._ticks / seconds,
            loop.late,
            loop.skipped,
            self._readings / seconds,
            snapshot,
            tuple(devices),
        )
        self._looked_ns, self._ticks, self._readings = snapshot.stamp_ns, 0, 0
        return status
