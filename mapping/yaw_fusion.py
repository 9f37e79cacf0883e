"""The turn from wheels and gyro together, and whether they agree."""

from collections import deque
from dataclasses import replace
from math import radians

from echogrid.mapping.gyro import WIDEST_GAP_NS, Gyro
from echogrid.mapping.kinematics import Motion

_MISMATCH = radians(0.5)
_WINDOW_NS = 1_000_000_000
_SLIP_DOUBT = 10.0
"""How much larger the variance of the way is while the wheels slip."""
_STANDING = 1e-3, 1e-3
"""m/s and rad/s: what is slower stands."""
_SETTLE_NS = 500_000_000
"""It must stand for so long before the gyro's bias is taken: a robot still rocks after it stopped."""


class YawFusion:
    """Mends the wheels' motions with a gyro, whose bias it learns while they stand.

    `noise` is the gyro's, in rad^2 of the turn per s (the square of its angle random walk). Before the bias
    is known, and where the gyro does not cover a motion, the wheels alone are believed.
    """

    def __init__(self, gyro: Gyro, noise: float) -> None:
        self.gyro = gyro
        self.slips = 0
        """How often the wheels began to slip."""
        self.slipped_ns = 0
        """For how long they did."""
        self._slipped = False
        self._noise = noise
        self._window: deque[tuple[int, float]] = deque()
        self._standing_ns = 0

    @property
    def slipping(self) -> bool:
        """Whether wheels and gyro differ by more than 0.5 deg over the last second."""
        return abs(sum(difference for _, difference in self._window)) > _MISMATCH

    def fused(self, start_ns: int, end_ns: int, motion: Motion) -> Motion:
        """The motion with the likelier turn: both weighted by their variances, or, while the wheels slip, the
        gyro's alone. Calls follow one another in time."""
        self._look_for_bias(start_ns, end_ns, motion)
        turned = self.gyro.turned(start_ns, end_ns) if self.gyro.settled else None
        if turned is None:
            self._window.clear()
            self._slipped = False
            return motion
        self._window.append((end_ns, motion.turn - turned))
        while self._window[0][0] <= end_ns - _WINDOW_NS:
            self._window.popleft()
        self._count_slip(end_ns - start_ns)
        variance = self._noise * (end_ns - start_ns) * 1e-9
        if self._slipped:
            doubt = motion.forward_variance * _SLIP_DOUBT
            return Motion(motion.forward, turned, doubt, variance)
        return _corrected(motion, turned, variance)

    def _count_slip(self, interval_ns: int) -> None:
        before, self._slipped = self._slipped, self.slipping
        self.slips += self._slipped and not before
        self.slipped_ns += interval_ns if self._slipped else 0

    def _look_for_bias(self, start_ns: int, end_ns: int, motion: Motion) -> None:
        seconds = (end_ns - start_ns) * 1e-9
        slow = abs(motion.forward) < _STANDING[0] * seconds and abs(motion.turn) < _STANDING[1] * seconds
        slow = slow and end_ns - start_ns <= WIDEST_GAP_NS  # Meanwhile a wheel may have restarted.
        if slow and self._standing_ns >= _SETTLE_NS:
            self.gyro.stood(start_ns, end_ns)
        self._standing_ns = self._standing_ns + end_ns - start_ns if slow else 0


def _corrected(motion: Motion, turned: float, variance: float) -> Motion:
    """The motion given that its turn was measured (a Kalman filter's update)."""
    total = motion.turn_variance + variance
    gain, gain_forward = motion.turn_variance / total, motion.shared / total
    surprise = turned - motion.turn
    return replace(
        motion,
        forward=motion.forward + gain_forward * surprise,
        turn=motion.turn + gain * surprise,
        forward_variance=motion.forward_variance - gain_forward * motion.shared,
        turn_variance=motion.turn_variance * (1.0 - gain),
        shared=motion.shared * (1.0 - gain),
    )
