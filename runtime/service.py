"""A run: the loop around the tick, whatever the clock and wherever the readings come from."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import degrees, sqrt
from typing import Any, Protocol

from echogrid.drivers.clock import Clock
from echogrid.drivers.device import Health, State
from echogrid.drivers.readings import RangeReading, Reading
from echogrid.mapping.odometry import Odometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.reckoning import YawRate
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime.acquisition import Acquisition, DeviceReport
from echogrid.runtime.fusion import Fusion, Snapshot
from echogrid.runtime.ledger_report import account
from echogrid.runtime.loop import SECOND_NS, FixedRateLoop
from echogrid.runtime.outputs.publisher import Publisher
from echogrid.runtime.reading_text import source
from echogrid.runtime.status import Meter, Status
from echogrid.runtime.voyage import Voyage

_PATH_NS = SECOND_NS // 10
_NEVER_NS = 1 << 62


class Sink(Protocol):
    """Takes what each tick took in."""

    def put(
        self, ranges: tuple[RangeReading, ...], wheels: tuple[WheelAngles, ...], rates: tuple[YawRate, ...]
    ) -> None:
        """Must not wait."""
        ...


@dataclass(slots=True)
class Run:
    """A run in progress, and its results afterwards."""

    fusion: Fusion
    loop: FixedRateLoop
    acquisition: Acquisition
    clock: Clock
    sinks: tuple[Sink, ...] = ()
    path: list[tuple[int, Pose]] = field(default_factory=list)
    """Stamps and poses of the robot, at most ten a second."""
    readings: Counter[str] = field(default_factory=Counter)
    """By device."""
    stopping: bool = False
    publisher: Publisher = field(default_factory=Publisher)
    voyage: Voyage | None = None
    """If the robot is driven."""

    @property
    def travelled(self) -> float:
        """m."""
        return self.fusion.odometry.travelled

    def go(self, duration_s: float | None, show: Callable[[Status], None]) -> None:
        """Tick until the time is over or `stopping` is set; then take what is left, and fuse it.

        A robot that is driven is stopped then, for which it goes on ticking.
        """
        started_ns = self.clock.now_ns()
        until_ns = _NEVER_NS if duration_s is None else started_ns + round(duration_s * SECOND_NS)
        meter = Meter(started_ns)
        for now_ns in self.loop.ticks(_NEVER_NS if self.voyage else until_ns):
            readings = self.acquisition.drain()
            snapshot = self._tick(now_ns, readings)
            meter.count(len(readings))
            if meter.due(now_ns):
                status = meter.look(snapshot, self.loop, self.devices(now_ns))
                show(replace(status, drive=self.voyage.told) if self.voyage else status)
            if self._over(self.stopping or now_ns >= until_ns):
                break
        self.acquisition.stop()
        self._tick(self.clock.now_ns(), self.acquisition.drain())
        self.fusion.finish()

    def _tick(self, now_ns: int, readings: list[Reading]) -> Snapshot:
        snapshot = self.fusion.tick(now_ns, readings)
        if self.voyage:
            self.voyage.tick(snapshot, readings, self.acquisition.report(now_ns))
        self.fusion.overflow(self.acquisition.drain_overflow())
        for sink in self.sinks:
            sink.put(snapshot.ranges, snapshot.wheels, snapshot.rates)
        self.publisher.put(snapshot.view)
        self._remember(snapshot, readings)
        return snapshot

    def _over(self, stopping: bool) -> bool:
        """Whether the run is at its end: one that drives has stopped and let the motors go by then."""
        if not self.voyage:
            return stopping
        if stopping:
            self.voyage.stop()
        return self.voyage.over

    def _remember(self, snapshot: Snapshot, readings: list[Reading]) -> None:
        for reading in readings:
            self.readings[source(reading)] += 1
        stamp_ns = snapshot.pose_ns
        if stamp_ns is not None and (not self.path or stamp_ns - self.path[-1][0] >= _PATH_NS):
            self.path.append((stamp_ns, snapshot.pose))

    def devices(self, now_ns: int) -> list[DeviceReport]:
        """How every device is: what it says itself, and what the robot's motion says of it."""
        stuck = self.fusion.stuck.stuck()
        return [_watched(each, stuck.get(each.device)) for each in self.acquisition.report(now_ns)]

    def report(self, devices: Sequence[DeviceReport]) -> dict[str, Any]:
        """What report.json holds."""
        return {
            **account(self.fusion.ledger, self.fusion.waiting),
            "readings_by_device": dict(sorted(self.readings.items())),
            "crosstalk": self.fusion.listening.report(),
            "wheel_readings_unpaired": self.fusion.unpaired,
            "wheel_restarts": self.fusion.restarts,
            "travelled_m": round(self.travelled, 3),
            "pose_error": _pose_error(self.fusion.odometry),
            **self._gyro(),
            "outputs": self.publisher.report(),
            **({"drive": self.voyage.report()} if self.voyage else {}),
            "ticks": {"in_time": self.loop.in_time, "late": self.loop.late, "skipped": self.loop.skipped},
            "devices": {
                each.device: {
                    "level": each.health.level.name,
                    "message": each.health.message,
                    "counts": dict(sorted(each.health.counts.items())),
                }
                for each in devices
            },
        }

    def _gyro(self) -> dict[str, Any]:
        """What the gyro says of the wheels, and of itself, if there is one."""
        fusion = self.fusion.odometry.yaw_fusion
        if fusion is None:
            return {}
        bias = round(degrees(fusion.gyro.bias), 4) if fusion.gyro.settled else None
        return {
            "wheel_slips": fusion.slips,
            "wheel_slip_s": round(fusion.slipped_ns / SECOND_NS, 3),
            "gyro_bias_dps": bias,
            "gyro_readings_late": self.fusion.late_rates,
        }


def _pose_error(odometry: Odometry) -> dict[str, float]:
    """How unsure the last pose is, as far as dead reckoning knows: standard deviations."""
    x, y, yaw = (sqrt(variance) for variance in odometry.covariance.diagonal())
    return {"x_m": round(x, 4), "y_m": round(y, 4), "yaw_deg": round(degrees(yaw), 3)}


def _watched(report: DeviceReport, stuck_at: float | None) -> DeviceReport:
    """The report of a device which says that it is well, but always says the same."""
    if stuck_at is None or report.health.state is not State.WELL:
        return report
    message = f"always {stuck_at:.3f} m, though the robot moves: is something before it, is it out of order?"
    return replace(report, health=Health(State.STUCK, message, report.health.counts))
