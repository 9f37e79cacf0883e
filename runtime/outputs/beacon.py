"""The obstacle view on a CAN bus of the robot: the loop hands it over, the bus's own thread sends it."""

from collections import Counter
from collections.abc import Mapping, Sequence

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import Health, State, Step
from echogrid.mapping.virtual_sensor import ObstacleView
from echogrid.runtime.outputs.can_frames import frames
from echogrid.runtime.outputs.pace import Pace

_LOOKS_PER_PERIOD = 4


class Beacon:
    """A device that only sends.

    Each view goes out once, so that the heartbeat ends with the loop; one that is overtaken before its bus
    has sent it is dropped.
    """

    port_options: Mapping[str, object] = {}

    def __init__(self, name: str, identifier: int, pace: Pace) -> None:
        self.name = name
        self.sent = 0
        self.dropped: Counter[str] = Counter()
        self._identifier = identifier
        self._pace = pace
        self._sequence = 0
        self._offered: tuple[int, Sequence[CanFrame]] | None = None
        self._taken = 0

    def put(self, view: ObstacleView) -> None:
        """Hand it over, if it is time. Called by the loop."""
        if not self._pace.due(view):
            return
        offered = frames(view, self._sequence, self._identifier)
        self._sequence += 1
        self._offered = self._sequence, offered

    def close(self) -> None:
        """There is nothing to let go: the bus is not its own."""

    def step(self, now_ns: int, received: Sequence[CanFrame]) -> Step[CanFrame]:  # noqa: ARG002 - it only sends
        """What was handed over since the last time. Called by the bus's thread."""
        deadline_ns = now_ns + self._pace.period_ns // _LOOKS_PER_PERIOD
        offered = self._offered
        if offered is None or offered[0] == self._taken:
            return Step(deadline_ns=deadline_ns)
        self._skip(offered[0] - 1, "bus too slow")
        self._taken = offered[0]
        self.sent += 1
        return Step(send=tuple(offered[1]), deadline_ns=deadline_ns)

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """What was handed over before is old when the port comes back."""
        self._skip(self._sequence, "bus lost")

    def health(self, now_ns: int) -> Health:  # noqa: ARG002 - as every device is told
        """How it is."""
        return Health(State.WELL, "tells what is ahead", {"views sent": self.sent})

    def _skip(self, upto: int, reason: str) -> None:
        if upto > self._taken:
            self.dropped[reason] += upto - self._taken
            self._taken = upto
