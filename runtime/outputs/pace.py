"""When a view goes out: at a rate, and at once when the robot must stop."""

from echogrid.mapping.virtual_sensor import ObstacleView

_SECOND_NS = 1_000_000_000


class Pace:
    """At most one view a period, by the views' own stamps; a stop that begins does not wait."""

    def __init__(self, rate_hz: float) -> None:
        self.period_ns = round(_SECOND_NS / rate_hz)
        self._due_ns: int | None = None
        self._stopped = False

    def due(self, view: ObstacleView) -> bool:
        """Whether to send it; to be asked about each view once."""
        begins, self._stopped = view.stop and not self._stopped, view.stop
        if self._due_ns is None:
            self._due_ns = view.stamp_ns
        if view.stamp_ns < self._due_ns:
            return begins
        missed = (view.stamp_ns - self._due_ns) // self.period_ns
        self._due_ns += (missed + 1) * self.period_ns
        return True
