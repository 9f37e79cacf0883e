"""Two wheels that report at their own times, brought to common stamps."""

from collections import deque
from dataclasses import dataclass

from echogrid.drivers.readings import WheelReading


@dataclass(frozen=True, slots=True)
class WheelAngles:
    """Both wheels at one moment: absolute, unwrapped angles in rad."""

    stamp_ns: int
    left: float
    right: float


class WheelPair:
    """Gives both wheels' angles at the left one's stamps, the right one's interpolated.

    A left reading waits for a right one that is not earlier; it is dropped, and counted in `unpaired`, where
    the right ones around it are further apart than `widest_gap_ns`, or were never seen. Either wheel's
    readings come in order, but one wheel's may come in a bunch after the other's.
    """

    def __init__(self, widest_gap_ns: int = 250_000_000, most_waiting: int = 256) -> None:
        self.unpaired = 0
        self._widest_gap_ns = widest_gap_ns
        self._most_waiting = most_waiting
        self._waiting: deque[WheelReading] = deque()
        self._rights: deque[WheelReading] = deque(maxlen=most_waiting)

    def left(self, reading: WheelReading) -> None:
        """Take a reading of the left wheel."""
        self._waiting.append(reading)
        if len(self._waiting) > self._most_waiting:
            self._waiting.popleft()
            self.unpaired += 1

    def right(self, reading: WheelReading) -> list[WheelAngles]:
        """Take a reading of the right wheel; the pairs which it completes, in order."""
        self._rights.append(reading)
        pairs = []
        while self._waiting and self._waiting[0].stamp_ns <= reading.stamp_ns:
            angles = self._paired(self._waiting.popleft())
            if angles is None:
                self.unpaired += 1
            else:
                pairs.append(angles)
        return pairs

    @property
    def waiting(self) -> int:
        """How many left readings have no partner yet."""
        return len(self._waiting)

    def _paired(self, left: WheelReading) -> WheelAngles | None:
        """With the right wheel's angle at that moment, if the newest right reading is not earlier."""
        rights = self._rights
        while len(rights) > 1 and rights[1].stamp_ns <= left.stamp_ns:
            rights.popleft()
        before = rights[0]
        if left.stamp_ns == before.stamp_ns:
            return WheelAngles(left.stamp_ns, left.angle, before.angle)
        if left.stamp_ns < before.stamp_ns:
            return None
        after = rights[1]
        gap_ns = after.stamp_ns - before.stamp_ns
        if gap_ns > self._widest_gap_ns:
            return None
        fraction = (left.stamp_ns - before.stamp_ns) / gap_ns
        right = before.angle + fraction * (after.angle - before.angle)
        return WheelAngles(left.stamp_ns, left.angle, right)
