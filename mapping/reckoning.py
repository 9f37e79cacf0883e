"""Dead reckoning from wheels and yaw rates which come at their own times.

A motion waits until the gyro covers it. So the poses depend on the stamps alone, not on which of both came
first, and those of a log equal those of the run.
"""

from collections import deque
from dataclasses import dataclass

from echogrid.mapping.gyro import WIDEST_GAP_NS
from echogrid.mapping.odometry import Odometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.wheel_pair import WheelAngles

_MOST_RATES = 4096
_LONG_AGO_NS = -(1 << 62)

StampedPose = tuple[int, Pose]


@dataclass(frozen=True, slots=True)
class YawRate:
    """How fast the robot turns at one moment, by its gyro."""

    stamp_ns: int
    rate: float
    """rad/s, counter-clockwise."""


class Reckoning:
    """Hands wheels and rates to the odometry in the order of their stamps.

    Both wheels' angles at a stamp wait for a rate that is not earlier. When the wheels are ahead of the
    newest rate by the widest gap which the gyro bridges, it has fallen silent: all that waits is reckoned by
    the wheels alone, and what the gyro may still say of that time is refused. Without a gyro nothing waits.
    """

    def __init__(self, odometry: Odometry) -> None:
        self.odometry = odometry
        self.refused = 0
        """Rates that came too late."""
        fusion = odometry.yaw_fusion
        self._gyro = fusion.gyro if fusion else None
        self._rates: deque[YawRate] = deque()
        """Those which the gyro does not have yet."""
        self._waiting: deque[WheelAngles] = deque()
        self._wheels_ns = self._blind_ns = _LONG_AGO_NS
        self._heard_ns = self._rated_ns = self._handed_ns = _LONG_AGO_NS

    def rate(self, rate: YawRate) -> bool:
        """Take a rate; False, and nothing taken, unless it is later than all that was reckoned without it."""
        if self._gyro is None:
            return False
        self._heard_ns = max(self._heard_ns, rate.stamp_ns)
        if rate.stamp_ns <= max(self._rated_ns, self._blind_ns):
            self.refused += 1
            return False
        self._rated_ns = rate.stamp_ns
        self._rates.append(rate)
        if len(self._rates) > _MOST_RATES:
            self._hand_over()
        return True

    def wheels(self, angles: WheelAngles) -> bool:
        """Take both wheels' angles; False, and nothing taken, unless they are later than the last."""
        if angles.stamp_ns <= self._wheels_ns:
            return False
        self._wheels_ns = angles.stamp_ns
        self._waiting.append(angles)
        return True

    def poses(self) -> list[StampedPose]:
        """The poses that can be told now, in order."""
        if self._wheels_ns > self._heard_ns + WIDEST_GAP_NS:
            return self.finish()
        return self._reckoned(self._rated_ns)

    def finish(self) -> list[StampedPose]:
        """The poses that are still to be told, by the wheels alone where no rate came."""
        poses = self._reckoned(self._wheels_ns)
        if self._wheels_ns > self._rated_ns:
            self._blind_ns = self._wheels_ns
        return poses

    def _reckoned(self, until_ns: int) -> list[StampedPose]:
        poses: list[StampedPose] = []
        while self._waiting and self._waiting[0].stamp_ns <= until_ns:
            poses.append(self._moved(self._waiting.popleft()))
        return poses

    def _moved(self, angles: WheelAngles) -> StampedPose:
        """The next pose. The gyro gets the rates up to the first which is not earlier, and no others: what it
        remembers must not depend on what has come already."""
        while self._rates and self._handed_ns < angles.stamp_ns:
            self._hand_over()
        pose = self.odometry.update(angles.stamp_ns, angles.both, angles.restarted)
        return angles.stamp_ns, pose

    def _hand_over(self) -> None:
        rate = self._rates.popleft()
        self._handed_ns = rate.stamp_ns
        if self._gyro is not None:
            self._gyro.add(rate.stamp_ns, rate.rate)
