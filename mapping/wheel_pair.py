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
    restarted: bool = False
    """They were led on with zero motion from the last pair: a wheel jumped since."""


class WheelPair:
    """Gives both wheels' angles at the left one's stamps, the right one's interpolated.

    A left reading waits for a right one that is not earlier; it is dropped, and counted in `unpaired`, where
    the right ones around it are further apart than `widest_gap_ns`, or were never seen. Either wheel's
    readings come in order, but one wheel's may come in a bunch after the other's.

    After a discontinuity of one wheel nobody knows what it turned meanwhile, while the other one went on
    counting: taken together they would turn the robot. So the pair goes on where it was, with zero motion of
    both wheels, and `restarts` counts it.
    """

    def __init__(self, widest_gap_ns: int = 250_000_000, most_waiting: int = 256) -> None:
        self.unpaired = 0
        self.restarts = 0
        self._widest_gap_ns = widest_gap_ns
        self._most_waiting = most_waiting
        self._waiting: deque[WheelReading] = deque()
        self._rights: deque[WheelReading] = deque(maxlen=most_waiting)
        self._jumps_ns: deque[int] = deque(maxlen=most_waiting)
        self._given: WheelAngles | None = None
        self._lead = (0.0, 0.0)

    def left(self, reading: WheelReading) -> None:
        """Take a reading of the left wheel."""
        self._note_jump(reading)
        self._waiting.append(reading)
        if len(self._waiting) > self._most_waiting:
            self._waiting.popleft()
            self.unpaired += 1

    def right(self, reading: WheelReading) -> list[WheelAngles]:
        """Take a reading of the right wheel; the pairs which it completes, in order."""
        self._note_jump(reading)
        self._rights.append(reading)
        pairs = []
        while self._waiting and self._waiting[0].stamp_ns <= reading.stamp_ns:
            angles = self._paired(self._waiting.popleft())
            if angles is None:
                self.unpaired += 1
            else:
                pairs.append(self._continued(angles))
        return pairs

    @property
    def waiting(self) -> int:
        """How many left readings have no partner yet."""
        return len(self._waiting)

    def _note_jump(self, reading: WheelReading) -> None:
        if reading.discontinuity:
            self._jumps_ns.append(reading.stamp_ns)

    def _continued(self, raw: WheelAngles) -> WheelAngles:
        """The angles, led on from the last pair where a wheel jumped since."""
        jumped = [stamp_ns for stamp_ns in self._jumps_ns if stamp_ns <= raw.stamp_ns]
        if jumped:
            self._jumps_ns = deque(set(self._jumps_ns) - set(jumped), self._jumps_ns.maxlen)
            self.restarts += 1
            if self._given is not None:
                self._lead = self._given.left - raw.left, self._given.right - raw.right
        lead_left, lead_right = self._lead
        self._given = WheelAngles(raw.stamp_ns, raw.left + lead_left, raw.right + lead_right, bool(jumped))
        return self._given

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
        if gap_ns > self._widest_gap_ns or after.discontinuity:
            return None
        fraction = (left.stamp_ns - before.stamp_ns) / gap_ns
        right = before.angle + fraction * (after.angle - before.angle)
        return WheelAngles(left.stamp_ns, left.angle, right)
