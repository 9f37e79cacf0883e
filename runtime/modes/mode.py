"""What a drive mode is: from what is known now to the twist that is wanted."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.planning.tracking import PlanTracker
from echogrid.mapping.pose import Pose
from echogrid.mapping.twist import Twist


@dataclass(frozen=True, slots=True)
class Situation:
    """A moment, for whoever decides."""

    now_ns: int
    pose: Pose
    """In the odom frame, as the grid."""
    local: LocalGrid
    """Centred on the robot."""
    twist: Twist
    """That the motors are asked for."""
    elapsed_s: float
    """Since the last one."""


@dataclass(frozen=True, slots=True)
class End:
    """Why a mode has no more to do."""

    reached: bool
    """Whether it did what it was to do."""
    told: str
    """For people."""


class Mode(Protocol):
    """One thread owns it. In each tick it is asked for its wish or, while it can't drive, told to rest."""

    name: str
    end: End | None
    """None while it goes on."""
    patient: bool
    """Whether it waits for motors that are not ready for as long as they take."""
    tracker: PlanTracker | None
    """Where the robot is on the floor plan by which it drives, if there is one: the lookout must have it."""

    def wish(self, situation: Situation) -> Twist:
        """The twist that is wanted; what of it is safe is decided elsewhere."""
        ...

    def report(self) -> Mapping[str, Any]:
        """What report.json holds of it, besides what it holds of all modes."""
        ...

    def rest(self, now_ns: int, /) -> None:
        """The robot can't drive now: what is wished for meanwhile counts for nothing afterwards."""
        ...
