"""One drive with one twist: enable the motors, drive, stop, let them go."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from echogrid.drivers.device import State
from echogrid.drivers.readings import Reading, WheelReading
from echogrid.drivers.throttle import FRESH_NS
from echogrid.runtime.acquisition import DeviceReport
from echogrid.runtime.driving import Driving

SECOND_NS = 1_000_000_000
ENABLE_WITHIN_NS = 5 * SECOND_NS
STOP_WITHIN_NS = 2 * SECOND_NS
LET_GO_NS = SECOND_NS // 10
SOUND = frozenset({State.WELL, State.HOT, State.ERROR_PASSIVE})
"""A wheel in another state is not driven."""
STANDING = 0.05
"""rad/s of a wheel: what is slower stands."""


class Stage(Enum):
    """What is going on."""

    ENABLING = "enabling the motors"
    DRIVING = "driving"
    STOPPING = "stopping"
    LETTING_GO = "letting the motors go"
    OVER = "over"


@dataclass(frozen=True, slots=True)
class Wanted:
    """What the robot shall do."""

    speed: float
    """m/s."""
    turn_rate: float
    """rad/s."""
    lasts_ns: int


class Excursion:
    """Called at the loop's rate. Whatever goes wrong with a wheel ends the drive."""

    def __init__(self, driving: Driving, wanted: Wanted) -> None:
        self.stage = Stage.ENABLING
        self.trouble = ""
        """Why it ended early; empty if it did not."""
        self._driving = driving
        self._wanted = wanted
        self._since_ns: int | None = None
        self._ticked_ns: int | None = None
        self._rates: dict[str, float] = {}
        self._stopped = False

    def tick(self, now_ns: int, readings: Sequence[Reading], reports: Sequence[DeviceReport]) -> None:
        """Take what the wheels report, and ask them for what is to come."""
        self._rates |= {each.wheel: each.rate for each in readings if isinstance(each, WheelReading)}
        if self._since_ns is None:
            self._since_ns = now_ns
        following = self._following(now_ns, now_ns - self._since_ns, reports)
        if following is not self.stage:
            self.stage, self._since_ns = following, now_ns
        self._ticked_ns = now_ns
        self._ask(now_ns)

    def stop(self) -> None:
        """End it with the next tick."""
        self._stopped = True
        self.trouble = self.trouble or "stopped before its time"

    def _following(self, now_ns: int, age_ns: int, reports: Sequence[DeviceReport]) -> Stage:
        """The stage that is due, given for how long this one lasts."""
        if self._stopped and self.stage in (Stage.ENABLING, Stage.DRIVING):
            return Stage.STOPPING
        if self.stage is Stage.ENABLING:
            return self._after_enabling(age_ns, reports)
        if self.stage is Stage.DRIVING:
            return self._after_driving(now_ns, age_ns, reports)
        if self.stage is Stage.STOPPING:
            return self._after_stopping(age_ns, reports)
        return Stage.OVER if age_ns >= LET_GO_NS else self.stage

    def _after_enabling(self, age_ns: int, reports: Sequence[DeviceReport]) -> Stage:
        if self._driving.obeyed and not failing(reports):
            return Stage.DRIVING
        if age_ns < ENABLE_WITHIN_NS:
            return Stage.ENABLING
        self.trouble = f"the motors can't be enabled: {told(reports)}"
        return Stage.STOPPING

    def _after_driving(self, now_ns: int, age_ns: int, reports: Sequence[DeviceReport]) -> Stage:
        pause_ns = now_ns - (self._ticked_ns or now_ns)
        if pause_ns > FRESH_NS:  # The wheels were stopped meanwhile, and must not start by themselves.
            self.trouble = f"stopped early: it paused for {pause_ns * 1e-9:.1f} s: is this machine too busy?"
            return Stage.STOPPING
        if not self._driving.obeyed or failing(reports):
            self.trouble = f"stopped early: {told(reports)}"
            return Stage.STOPPING
        return Stage.STOPPING if age_ns >= self._wanted.lasts_ns else Stage.DRIVING

    def _after_stopping(self, age_ns: int, reports: Sequence[DeviceReport]) -> Stage:
        standing = all(abs(rate) < STANDING for rate in self._rates.values())
        if standing and age_ns >= LET_GO_NS:
            return Stage.LETTING_GO
        if age_ns < STOP_WITHIN_NS:
            return Stage.STOPPING
        self.trouble = self.trouble or f"the wheels still turned when they were let go: {told(reports)}"
        return Stage.LETTING_GO

    def _ask(self, now_ns: int) -> None:
        if self.stage is Stage.DRIVING:
            self._driving.ask(now_ns, self._wanted.speed, self._wanted.turn_rate)
        elif self.stage in (Stage.ENABLING, Stage.STOPPING):
            self._driving.ask(now_ns, 0.0, 0.0)
        else:
            self._driving.release()


def failing(reports: Sequence[DeviceReport]) -> bool:
    """Whether anything is wrong with a wheel that ends a drive."""
    return any(each.health.state not in SOUND for each in reports)


def told(reports: Sequence[DeviceReport]) -> str:
    """What the wheels say of themselves."""
    return "; ".join(f"{each.device}: {each.health.state.value}: {each.health.message}" for each in reports)
