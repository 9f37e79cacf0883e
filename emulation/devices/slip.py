"""A wheel that may slip: its shaft turns on without the robot."""

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.shaft import Shaft

_RATE = 3.0
"""rad/s by which it turns faster than the robot goes."""


class SlippingShaft(Shaft):
    """The shaft as its encoder sees it. What it slipped is not lost: the angle goes on from there."""

    def __init__(self, shaft: Shaft) -> None:
        super().__init__(shaft)
        self._shaft = shaft
        self._spells: list[tuple[int, int]] = []
        """From when to when it slipped."""

    def __call__(self, now_ns: int) -> float:
        """Its angle, rad of the wheel."""
        slipped_ns = sum(max(0, min(now_ns, end_ns) - start_ns) for start_ns, end_ns in self._spells)
        return self._shaft(now_ns) + _RATE * slipped_ns * 1e-9

    def drive(self, rate: float, now_ns: int) -> None:
        """The motor holds it at that rate (rad/s of the wheel) from now on."""
        self._shaft.drive(rate, now_ns)

    def release(self, now_ns: int) -> None:
        """The motor lets it roll."""
        self._shaft.release(now_ns)

    def lose_grip(self, now_ns: int) -> None:
        """Fault `slip`: it spins."""
        self._spells.append((now_ns, NEVER_NS))

    def grip(self, now_ns: int) -> None:
        """The end of `slip`."""
        start_ns, _ = self._spells.pop()
        self._spells.append((start_ns, now_ns))
