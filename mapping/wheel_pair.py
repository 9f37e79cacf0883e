"""Two wheels that report at their own times, brought to common stamps."""

from collections import deque
from dataclasses import dataclass

from echogrid.drivers.readings import WheelReading
from echogrid.mapping.kinematics import Angles, Differential, Wheels


@dataclass(frozen=True, slots=True)
class WheelAngles:
    """Both wheels at one moment: absolute, unwrapped angles in rad."""

    stamp_ns: int
    first: float
    """Of the left wheel or, of a steered drive, the driven one."""
    second: float
    """Of the right wheel, or of the steering."""
    restarted: bool = False
    """They were led on with zero motion from the last pair: a wheel jumped since."""

    @property
    def both(self) -> Angles:
        """The angles alone."""
        return self.first, self.second


class WheelPair:
    """Gives both wheels' angles at the first one's stamps, the second one's interpolated.

    A reading of the first waits for one of the second that is not earlier; it is dropped, and counted in
    `unpaired`, where the second's around it are further apart than `widest_gap_ns`, or were never seen.
    Either wheel's readings come in order, but one wheel's may come in a bunch after the other's.

    After a discontinuity of one wheel nobody knows what it turned meanwhile, while the other one went on
    counting: taken together they would turn the robot. So the pair goes on where it was, with zero motion of
    both wheels, and `restarts` counts it. An angle of steering is absolute: it is never led on, and it has no
    restarts.
    """

    def __init__(
        self,
        wheels: Wheels = Differential.wheels,
        widest_gap_ns: int = 250_000_000,
        most_waiting: int = 256,
    ) -> None:
        self.unpaired = 0
        self.restarts = 0
        self._wheels = wheels
        self._widest_gap_ns = widest_gap_ns
        self._most_waiting = most_waiting
        self._waiting: deque[WheelReading] = deque()
        self._seconds: deque[WheelReading] = deque(maxlen=most_waiting)
        self._jumps_ns: deque[int] = deque(maxlen=most_waiting)
        self._given: WheelAngles | None = None
        self._lead = (0.0, 0.0)

    def take(self, reading: WheelReading) -> list[WheelAngles]:
        """Take a reading of either wheel; the pairs which it completes, in order."""
        second = reading.wheel == self._wheels.second
        if reading.discontinuity and not (second and self._wheels.steered):
            self._jumps_ns.append(reading.stamp_ns)
        return self._take_second(reading) if second else self._take_first(reading)

    @property
    def waiting(self) -> int:
        """How many of the first wheel's readings have no partner yet."""
        return len(self._waiting)

    def _take_first(self, reading: WheelReading) -> list[WheelAngles]:
        self._waiting.append(reading)
        if len(self._waiting) > self._most_waiting:
            self._waiting.popleft()
            self.unpaired += 1
        return []

    def _take_second(self, reading: WheelReading) -> list[WheelAngles]:
        self._seconds.append(reading)
        pairs = []
        while self._waiting and self._waiting[0].stamp_ns <= reading.stamp_ns:
            angles = self._paired(self._waiting.popleft())
            if angles is None:
                self.unpaired += 1
            else:
                pairs.append(self._continued(angles))
        return pairs

    def _continued(self, raw: WheelAngles) -> WheelAngles:
        """The angles, led on from the last pair where a wheel jumped since."""
        jumped = [stamp_ns for stamp_ns in self._jumps_ns if stamp_ns <= raw.stamp_ns]
        if jumped:
            self._jumps_ns = deque(set(self._jumps_ns) - set(jumped), self._jumps_ns.maxlen)
            self.restarts += 1
            if self._given is not None:
                second = 0.0 if self._wheels.steered else self._given.second - raw.second
                self._lead = self._given.first - raw.first, second
        first, second = self._lead
        self._given = WheelAngles(raw.stamp_ns, raw.first + first, raw.second + second, bool(jumped))
        return self._given

    def _paired(self, first: WheelReading) -> WheelAngles | None:
        """With the second wheel's angle at that moment, if its newest reading is not earlier."""
        seconds = self._seconds
        while len(seconds) > 1 and seconds[1].stamp_ns <= first.stamp_ns:
            seconds.popleft()
        before = seconds[0]
        if first.stamp_ns == before.stamp_ns:
            return WheelAngles(first.stamp_ns, first.angle, before.angle)
        if first.stamp_ns < before.stamp_ns:
            return None
        after = seconds[1]
        gap_ns = after.stamp_ns - before.stamp_ns
        if gap_ns > self._widest_gap_ns or after.discontinuity:
            return None
        fraction = (first.stamp_ns - before.stamp_ns) / gap_ns
        second = before.angle + fraction * (after.angle - before.angle)
        return WheelAngles(first.stamp_ns, first.angle, second)
