"""Keeps the motors ready, and hands them the twist of a drive mode, each tick."""

from collections.abc import Sequence
from enum import Enum

from echogrid.drivers.throttle import FRESH_NS
from echogrid.mapping.twist import Twist
from echogrid.runtime.acquisition import DeviceReport
from echogrid.runtime.driving import Driving
from echogrid.runtime.excursion import failing

STANDSTILL = Twist()
SETTLE_NS = 500_000_000
"""After any trouble zero is asked for so long before the robot drives again."""


class HelmState(Enum):
    """What becomes of the twists."""

    RELEASED = "motors let go"
    READYING = "enabling the motors"
    DRIVING = "driving"


class Helm:
    """Called at the loop's rate. A wheel that fails, a motor that is let go by somebody else, and a pause of
    the loop all lead to zero, and from there, when all is well again, back.

    It never decides where to go. When it is called no more, the throttles run dry within 200 ms.
    """

    def __init__(self, driving: Driving) -> None:
        self.state = HelmState.RELEASED
        self.stops = 0
        """How often the robot had to stop for its motors' or the loop's sake."""
        self._driving = driving
        self._ticked_ns: int | None = None
        self._well_since_ns: int | None = None

    def steer(self, now_ns: int, wanted: Twist, reports: Sequence[DeviceReport]) -> Twist:
        """Ask the motors for a twist; what of it they are asked for."""
        paused = self._ticked_ns is not None and now_ns - self._ticked_ns > FRESH_NS
        self._ticked_ns = now_ns
        well = self._driving.obeyed and not failing(reports) and not paused
        if not well:
            self._well_since_ns = None
        elif self._well_since_ns is None:
            self._well_since_ns = now_ns
        drives = self._well_since_ns is not None and now_ns - self._well_since_ns >= SETTLE_NS
        self.stops += self.state is HelmState.DRIVING and not drives
        self.state = HelmState.DRIVING if drives else HelmState.READYING
        asked = wanted if drives else STANDSTILL
        return Twist(*self._driving.ask(now_ns, asked.speed, asked.turn_rate))

    def release(self) -> None:
        """Let the motors go."""
        self._driving.release()
        self.state, self._ticked_ns, self._well_since_ns = HelmState.RELEASED, None, None
