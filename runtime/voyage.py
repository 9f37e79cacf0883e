"""Driving by a mode: what it wishes, what of that is safe, and an orderly end."""

from collections.abc import Sequence
from enum import Enum
from typing import Any

from echogrid.drivers.device import BusLine, Device
from echogrid.drivers.readings import Reading, WheelReading
from echogrid.mapping.twist import Twist
from echogrid.runtime import assembly
from echogrid.runtime.acquisition import DeviceReport
from echogrid.runtime.config import Config
from echogrid.runtime.driving import Driving
from echogrid.runtime.excursion import LET_GO_NS, STANDING, STOP_WITHIN_NS, told
from echogrid.runtime.fusion import Fusion, Snapshot
from echogrid.runtime.helm import STANDSTILL, Helm, HelmState
from echogrid.runtime.modes.mode import End, Mode, Situation

POSE_NS = 300_000_000
"""A pose that is older is none."""
_READY_NS = 20_000_000_000
"""So long a mode that can't wait waits for its motors."""


class Leg(Enum):
    """What is going on."""

    UNDER_WAY = "under way"
    STOPPING = "stopping"
    LETTING_GO = "letting the motors go"
    OVER = "over"


class Voyage:
    """Called after each tick. A mode's end, or `stop`, leads to zero, and then the motors are let go.

    Of what a mode wishes the safe part is driven (Lookout.allowed).
    """

    def __init__(self, fusion: Fusion, helm: Helm, mode: Mode, wheels: Sequence[str]) -> None:
        self.leg = Leg.UNDER_WAY
        self.end: End | None = None
        """Why it ended by itself, if it did."""
        self._fusion = fusion
        self._helm = helm
        self._mode = mode
        self._wheels = frozenset(wheels)
        self._rates: dict[str, float] = {}
        self._asked = STANDSTILL
        self._ticked_ns: int | None = None
        self._since_ns: int | None = None
        """The leg; while under way: the motors were ready, or it began."""
        self._held = False
        self._stops = 0

    @property
    def over(self) -> bool:
        """Whether the motors are let go."""
        return self.leg is Leg.OVER

    @property
    def told(self) -> str:
        """How it goes, in a few words."""
        what = self._helm.state.value if self.leg is Leg.UNDER_WAY else self.leg.value
        return f"{self._mode.name}: {'held' if self._held else what}"

    def tick(self, snapshot: Snapshot, readings: Sequence[Reading], reports: Sequence[DeviceReport]) -> None:
        """Ask the motors for what is to come."""
        now_ns = snapshot.stamp_ns
        wheels = [each for each in reports if each.device in self._wheels]
        self._rates |= {each.wheel: each.rate for each in readings if isinstance(each, WheelReading)}
        if self._since_ns is None:
            self._since_ns = now_ns
        if self.leg is Leg.UNDER_WAY:
            self._drive(snapshot, wheels)
        else:
            self._come_to_rest(now_ns, wheels)
        self._fusion.twist = self._asked
        self._ticked_ns = now_ns

    def stop(self) -> None:
        """End it, from the next tick on."""
        if self.leg is Leg.UNDER_WAY:
            self._enter(Leg.STOPPING)

    def report(self) -> dict[str, Any]:
        """What report.json holds."""
        return {
            "mode": self._mode.name,
            "distance_m": round(self._fusion.odometry.travelled, 3),
            "stops": {"obstacles": self._stops, "motors": self._helm.stops},
            "end": self.end.told if self.end else None,
            **self._mode.report(),
        }

    def _drive(self, snapshot: Snapshot, wheels: Sequence[DeviceReport]) -> None:
        now_ns = snapshot.stamp_ns
        wanted = self._wanted(snapshot)
        self._asked = self._helm.steer(now_ns, wanted, wheels)
        if self._helm.state is HelmState.DRIVING and not _lost(snapshot):
            self._since_ns = now_ns
        self.end = self._mode.end or self._unready(now_ns, wheels)
        if self.end:
            self._enter(Leg.STOPPING)

    def _wanted(self, snapshot: Snapshot) -> Twist:
        """The safe part of what the mode wishes."""
        now_ns = snapshot.stamp_ns
        if _lost(snapshot) or self._helm.state is not HelmState.DRIVING:
            self._mode.rest(now_ns)
            return self._counted(STANDSTILL, held=False)
        wish = self._mode.wish(self._situation(snapshot))
        wanted = self._fusion.allowed(now_ns, wish)
        return self._counted(wanted, held=wanted.stands and not wish.stands)

    def _situation(self, snapshot: Snapshot) -> Situation:
        now_ns = snapshot.stamp_ns
        return Situation(
            now_ns,
            snapshot.pose,
            self._fusion.local,
            self._asked,
            (now_ns - (self._ticked_ns or now_ns)) * 1e-9,
        )

    def _counted(self, wanted: Twist, held: bool) -> Twist:
        self._stops += held and not self._held
        self._held = held
        return wanted

    def _unready(self, now_ns: int, wheels: Sequence[DeviceReport]) -> End | None:
        waited_ns = now_ns - (self._since_ns or now_ns)
        if self._mode.patient or waited_ns < _READY_NS:
            return None
        if self._helm.state is HelmState.DRIVING:
            return End(False, f"no pose for {waited_ns * 1e-9:.0f} s: {told(wheels)}")
        return End(False, f"the motors are not ready: {told(wheels)}")

    def _come_to_rest(self, now_ns: int, wheels: Sequence[DeviceReport]) -> None:
        age_ns = now_ns - (self._since_ns or now_ns)
        if self.leg is not Leg.STOPPING:
            if age_ns >= LET_GO_NS:
                self._enter(Leg.OVER)
            return
        self._asked = self._helm.steer(now_ns, STANDSTILL, wheels)
        standing = all(abs(rate) < STANDING for rate in self._rates.values()) and age_ns >= LET_GO_NS
        if standing or age_ns >= STOP_WITHIN_NS:
            if not standing:
                self.end = End(False, f"the wheels still turned when they were let go: {told(wheels)}")
            self._helm.release()
            self._enter(Leg.LETTING_GO)

    def _enter(self, leg: Leg) -> None:
        self.leg, self._since_ns, self._held = leg, None, False


def _lost(snapshot: Snapshot) -> bool:
    """Whether nobody knows where the robot is."""
    return snapshot.pose_ns is None or snapshot.stamp_ns - snapshot.pose_ns > POSE_NS


Parts = tuple[list[BusLine[Any, Any]], Fusion, Voyage | None]
"""Of a run: the devices of each bus, the tick's state, and what drives."""


def commissioned(
    config: Config, mode: Mode | None, beacons: Sequence[tuple[str, Device[Any, Any]]] = ()
) -> Parts:
    """The parts of a run, and what drives it if there is a mode. Raises ConfigError, also for wheels that
    can't be driven."""
    if mode is None:
        return *assembly.parts(config, beacons), None
    driving = Driving(config, assembly.differential(config, f"the mode {mode.name}"))
    devices, fusion = assembly.parts(config, beacons, driving.throttles, mode.tracker)
    return devices, fusion, Voyage(fusion, Helm(driving), mode, tuple(driving.throttles))
