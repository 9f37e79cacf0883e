"""Somebody else wishes; the voyage passes on the safe part of it."""

from collections.abc import Mapping
from typing import Any

from echogrid.mapping.planning.tracking import PlanTracker
from echogrid.mapping.twist import Twist
from echogrid.runtime.modes.mode import End, Situation
from echogrid.runtime.wishes import Wishes


class Guard:
    """Without a fresh wish it stands. It never ends by itself."""

    name = "guard"
    patient = True
    tracker: PlanTracker | None = None

    def __init__(self, wishes: Wishes) -> None:
        self.end: End | None = None
        self._wishes = wishes

    def wish(self, situation: Situation) -> Twist:
        """The newest one."""
        return self._wishes.poll(situation.now_ns)

    def report(self) -> Mapping[str, Any]:
        """What came and was no wish."""
        return {"refused": dict(sorted(self._wishes.refused.items()))}

    def rest(self, now_ns: int) -> None:
        """Hear what is wished for, lest it wait in the socket and be taken for fresh afterwards."""
        self._wishes.poll(now_ns)
