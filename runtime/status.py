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

    def line(self) -> str:
        """For a terminal."""
        ailing = [each.device for each in self.devices if each.health.level is not Level.OK]
        health = f"{len(self.devices) - len(ailing)}/{len(self.devices)} devices ok"
        return (
            f"{self.elapsed_s:7.1f} s  {self.tick_rate_hz:5.1f} Hz  late {self.late}  "
            f"skipped {self.skipped}  {self.readings_per_s:5.0f} readings/s  {self._obstacle()}  "
            f"{self.snapshot.travelled:6.1f} m driven  {health}{': ' if ailing else ''}{', '.join(ailing)}"
        )

    def _obstacle(self) -> str:
        nearest = self.snapshot.view.nearest
        where = (
            "nearest   none"
            if isinf(nearest.nearest)
            else (f"nearest {nearest.nearest:.2f} m at {degrees(nearest.bearing):+4.0f} deg")
        )
        return f"{where}  {'STOP' if self.snapshot.view.stop else 'free'}"


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
